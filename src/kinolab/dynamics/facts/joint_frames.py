"""Frames that one draws to understand a machine: where its joints are, and along what they move.

A body's frame is a chain of motions. Wherever a coordinate moves the chain, a frame begins that
goes with it: the joint's. Its origin is where the joint is, and it is named after the coordinate.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.dynamics.derivation.vectors import Matrix3, Vector, Vectors
from kinolab.dynamics.language.frames import (
    Frame,
    Motion,
    Translation,
    movers_of,
    turn_matrix,
)
from kinolab.dynamics.language.mechanism_parts import MechanismParts

Pose: TypeAlias = tuple[Matrix3, Vector]


def joint_frames(system: MechanismParts) -> dict[Frame, str]:
    """Return the frames of a machine's joints with their names, but for those of bodies."""
    found: dict[Frame, str] = {}
    bodies = {body.frame for body in system.bodies}
    for body in system.bodies:
        for k, motion in enumerate(body.frame.motions, start=1):
            frame = Frame(body.frame.motions[:k])
            if frame not in bodies and (movers := movers_of(motion)):
                found[frame] = ", ".join(mover.name for mover in movers)
    return found


def pose_nodes(lower: Lowering, frames: Sequence[Frame]) -> list[Node]:
    """Return the rows of [R | p] of frames, 12 nodes each; chains that they share occur once."""
    vectors = Vectors(lower.tape)
    known: dict[tuple[Motion, ...], Pose] = {(): (vectors.identity, vectors.zero)}

    def pose(motions: tuple[Motion, ...]) -> Pose:
        if motions not in known:
            known[motions] = _moved(vectors, lower, *pose(motions[:-1]), motions[-1])
        return known[motions]

    found = [pose(frame.motions) for frame in frames]
    return [
        node for R, p in found for row, place in zip(R, p, strict=True) for node in (*row, place)
    ]


def _moved(vectors: Vectors, lower: Lowering, R: Matrix3, p: Vector, motion: Motion) -> Pose:
    """Return a pose after one more motion."""
    if isinstance(motion, Translation):
        arm = vectors.vector([lower(part) for part in motion.by])
        return R, vectors.add(p, vectors.transform(R, arm))
    turn = turn_matrix(motion)
    columns = [vectors.vector([lower(turn[i, j]) for i in range(3)]) for j in range(3)]
    a, b, c = (vectors.transform(R, column) for column in columns)
    return vectors.transpose((a, b, c)), p
