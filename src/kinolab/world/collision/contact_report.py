"""Who touches whom at a pose, and how: what is told to users."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.struct import Record
from kinolab.world.collision.broadphase import (
    ROUNDING_MARGIN,
    CheckerArrays,
    clear_of_meshes,
    grounded,
    place,
)
from kinolab.world.collision.fcl import Narrowphase, overlapping
from kinolab.world.distances.placed_shapes import enclose
from kinolab.world.distances.triangle_grid import inside, near_surface, overlap

GROUND_NAME = "ground"
LARGE = 50_000  # triangles, for which FCL builds its search tree in 0.2 s
Kind: TypeAlias = Literal["touches", "inside", "sinks", "near", "error"]


@dataclass(frozen=True)
class Contact:
    """One reason why a pose collides.

    ``body`` is a body's or a cable's name. ``obstacle`` is an obstacle's name, "ground", or the
    name of another part of the machine; it is empty where the body's own pose is not finite.
    ``kind`` says how: the surfaces meet ("touches"), the body is wholly inside a solid mesh
    ("inside"), it rests on the ground but is pressed into it ("sinks"), it is closer than the
    world's clearance ("near"), or it could not be judged ("error").
    """

    body: str
    obstacle: str
    kind: Kind

    @property
    def verb(self) -> str:
        """What the body does to the obstacle, in words."""
        return {"inside": "is inside", "sinks": "sinks into"}.get(self.kind, self.kind)


def contacts_at(
    poses: Array,
    sound: Sequence[int],
    owners: Sequence[str],
    obstacles: Sequence[str],
    record: Record,
    narrowphase: Narrowphase,
) -> Iterator[Contact]:
    """Yield what touches among a machine's shapes.

    Args:
        poses: Of the bodies, shape (bodies, 12).
        sound: The shapes whose places are finite.
        owners: The body or cable of each shape.
        obstacles: Names of the world's obstacles.
        record: The machine in its world, ``CheckerArrays``, cables placed in its scratch.
        narrowphase: Judges pairs of what is placed there.
    """
    arrays: CheckerArrays = record.held
    scene, scratch, grow = arrays.scene, arrays.scratch, arrays.scene.grow + ROUNDING_MARGIN
    near = np.empty(len(obstacles), np.int64)
    for s in sound:
        turn, at, body, box = scratch.turns[s], scratch.places[s], scene.body[s], scratch.around[s]
        if body >= 0:
            place(poses[body], scene.own[s], turn, at)
        enclose(scene.kind[s], scene.half[s], turn, at, grow, box)
        if scene.paired[s]:
            continue
        rests = scene.rests[s]
        if body >= 0 and scene.ground and grounded(box[2] + grow, rests, scene.margin):
            yield Contact(owners[s], GROUND_NAME, "sinks" if rests else "touches")
        for k in near[: overlapping(box, scene.obstacle, near)].tolist():
            how = _with_obstacle(s, k, record, narrowphase)
            if how is not None:
                yield Contact(owners[s], obstacles[k], how)
    for a, b in scene.own_pairs.tolist():
        if {a, b} <= {*sound} and overlap(scratch.around[a], scratch.around[b]):
            how = _judged(a, len(obstacles) + b, narrowphase)
            if how is not None:
                yield Contact(owners[a], owners[b], how)


def _with_obstacle(shape: int, k: int, record: Record, narrowphase: Narrowphase) -> Kind | None:
    """Say how a placed shape meets an obstacle; of small meshes FCL is always asked."""
    arrays: CheckerArrays = record.held
    mesh, box, kind = arrays.scene.mesh[k], arrays.scratch.around[shape], None
    grid, large = Record(arrays.grid), len(arrays.tree.triangles) > LARGE
    near = mesh < 0 or near_surface(box, mesh, grid)
    if near and not (mesh >= 0 and large and clear_of_meshes(shape, record)):
        kind = _judged(shape, k, narrowphase)
    if kind is None and mesh >= 0 and inside(arrays.scratch.places[shape], mesh, grid):
        return "inside"
    return kind


def _judged(shape: int, other: int, narrowphase: Narrowphase) -> Kind | None:
    try:
        return "touches" if narrowphase.any_touch([(shape, other)]) else None
    except Exception:  # whatever FCL raises, the pose was not found to be free
        return "error"
