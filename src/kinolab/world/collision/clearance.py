"""How far every point of the machine may move before anything can touch, as a proved bound."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.world.collision.gjk import Convex, box_gap, separation_within
from kinolab.world.collision.triangle_gaps import mesh_clearance
from kinolab.world.collision.triangle_grid import Integers
from kinolab.world.geometry import frame_in_world, sizes
from kinolab.world.obstacle import Obstacle
from kinolab.world.world import World


class ObstacleArrays(NamedTuple):
    """The obstacles of a world as numbers: the shapes of primitives; of meshes unused."""

    kind: Integers  # (obstacles,) values of ``geometry.ShapeKind``
    half: Array  # (obstacles, 3) half sizes in [m]
    turn: Array  # (obstacles, 3, 3)
    at: Array  # (obstacles, 3) centre in [m]


def obstacle_arrays(world: World) -> ObstacleArrays:
    """Gather the obstacles in arrays."""
    rows = [_shape(obstacle) for obstacle in world.obstacles]
    return ObstacleArrays(
        kind=np.array([kind for kind, _, _ in rows], dtype=np.int64),
        half=np.array([half for _, half, _ in rows]).reshape(-1, 3),
        turn=np.array([pose[:, :3] for _, _, pose in rows]).reshape(-1, 3, 3),
        at=np.array([pose[:, 3] for _, _, pose in rows]).reshape(-1, 3),
    )


def _shape(obstacle: Obstacle) -> tuple[int, Array, Array]:
    if obstacle.primitive is None:
        return 0, np.zeros(3), np.zeros((3, 4))
    kind, half = sizes(obstacle.primitive[0])
    return int(kind), half, np.column_stack(frame_in_world(*obstacle.primitive))


@kernel
def clearance_at(arrays):  # type: ignore[no-untyped-def]
    """Bound the clearance of placed shapes from below, in [m]; infinite in an empty world.

    Two shapes of the machine can approach each other from both sides: half their gap counts.

    Args:
        arrays: ``CheckerArrays``, as ``broadphase`` left them.
    """
    scratch, scene, fixed = arrays.scratch, arrays.scene, arrays.obstacles
    turns, places, around = scratch.turns, scratch.places, scratch.around
    kind, half, obstacle, own_pairs = scene.kind, scene.half, scene.obstacle, scene.own_pairs
    best = math.inf
    for s in range(kind.shape[0]):
        shape = Convex(kind[s], half[s], turns[s], places[s])
        if scene.ground and not scene.rests[s]:
            best = min(best, around[s, 2] + scene.grow)
        for k in range(obstacle.shape[0]):
            if scene.mesh[k] >= 0 or box_gap(around[s], obstacle[k]) >= best:
                continue
            other = Convex(fixed.kind[k], fixed.half[k], fixed.turn[k], fixed.at[k])
            best = min(best, separation_within(shape, other, 0.0, math.inf, scratch.simplex))
        best = mesh_clearance(shape, around[s], 0.0, best, arrays.tree, scratch)
    for k in range(own_pairs.shape[0]):
        a, b = own_pairs[k, 0], own_pairs[k, 1]
        if 0.5 * box_gap(around[a], around[b]) < best:
            gap = separation_within(
                Convex(kind[a], half[a], turns[a], places[a]),
                Convex(kind[b], half[b], turns[b], places[b]),
                0.0, math.inf, scratch.simplex,
            )  # fmt: skip
            best = min(best, 0.5 * gap)
    return best
