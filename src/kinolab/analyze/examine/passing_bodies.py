"""Which bodies pass through each other because no pair of them is named."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from kinolab.analyze.examine.subject import Subject
from kinolab.dynamics.machine_facts import BodyGeometry
from kinolab.numerics.arrays import Array
from kinolab.simulation.stability import random_states
from kinolab.world import CollisionChecker, World

MOST = 3  # pairs that are named; more are counted


def passing_bodies(subject: Subject) -> Iterator[str]:
    """Yield one sentence about the bodies that meet at some states and at others do not."""
    system, model = subject.system, subject.model
    solid = [body for body in system.bodies if body.shapes]
    geometry = [body for body in model.machine.bodies if body.shapes]
    watched = {frozenset(pair) for pair in (*system.collisions, *system.unwatched)}
    pairs = [(a.name, b.name) for a, b in combinations(solid, 2)]
    pairs = [pair for pair in pairs if frozenset(pair) not in watched]
    kept = [k for k, body in enumerate(system.bodies) if body.shapes]
    frames = model.frames(np.vstack([model.rest(), random_states(model)]))[:, kept]
    through = [pair for pair in pairs if _meets_sometimes(geometry, pair, frames)]
    if through:
        named = "; ".join(f"{a} and {b}" for a, b in through[:MOST])
        named += f"; {len(through) - MOST} further pairs" if len(through) > MOST else ""
        yield (
            f"These may pass through each other, since no pair is named: {named}. "
            f"collisions=[{through[0]!r}] keeps two apart."
        )


def _meets_sometimes(geometry: list[BodyGeometry], pair: tuple[str, str], frames: Array) -> bool:
    """Say whether two bodies touch at some of several poses, but not at all: not by a joint."""
    own = [k for k, body in enumerate(geometry) if body.name in pair]
    checker = CollisionChecker([geometry[k] for k in own], World(), self_pairs=[pair])
    found = [checker.collides(poses[own]) for poses in frames]
    return any(found) and not all(found)
