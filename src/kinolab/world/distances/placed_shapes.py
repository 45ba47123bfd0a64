"""Placed shapes in flat arrays, boxes around them, and the obstacles of a world among them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.language.shapes import Shape
from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.world.distances.obstacle_blocks import blocks_around
from kinolab.world.obstacles.kept_together import kept_together
from kinolab.world.obstacles.obstacle import Obstacle
from kinolab.world.shapes.geometry import carried, frame_in_world, placement, sizes, sizes_of
from kinolab.world.shapes.support_functions import HULL, half_extent

MANY = 2000  # obstacles, from which on it pays to bring neighbours together


class ObstacleArrays(NamedTuple):
    """Obstacles as numbers: the shapes of primitives, of meshes unused; boxes around all."""

    kind: NDArray[np.int64]  # (obstacles,) values of ``ShapeKind``
    half: Array  # (obstacles, 3) half sizes in [m]
    turn: Array  # (obstacles, 3, 3)
    at: Array  # (obstacles, 3) centre in [m]
    box: Array  # (obstacles, 6) lowest and highest x, y, z in [m]
    mesh: NDArray[np.int64]  # (obstacles,) which of the meshes it is, -1 for a primitive
    blocks: Array  # (blocks, 6) around obstacles that follow each other, as ``following`` asks
    first: Integers  # (layers,) block of each layer


@kept_together
def obstacle_arrays(obstacles: Sequence[Obstacle]) -> ObstacleArrays:
    """Gather obstacles in arrays, all primitives at once: a world may have hundreds of them."""
    count = len(obstacles)
    kind, half, box = np.zeros(count, np.int64), np.zeros((count, 3)), np.zeros((count, 6))
    turn, at = np.zeros((count, 3, 3)), np.zeros((count, 3))
    rows = [k for k, obstacle in enumerate(obstacles) if obstacle.primitive is not None]
    if rows:
        primitives = [obstacles[k].primitive for k in rows]
        shapes, poses = zip(*filter(None, primitives), strict=True)
        kind[rows], halves = zip(*(shape.lowered() for shape in shapes), strict=True)
        sized = sizes_of(halves)
        half = np.zeros((count, sized.shape[1]))
        half[rows] = sized
        turn[rows], at[rows] = carried(np.stack([*map(placement, shapes)]), np.array(poses))
        enclose_all(kind, half, turn, at, box)
    meshes = sorted({*range(count)}.difference(rows))
    for k in meshes:
        box[k, :3], box[k, 3:] = obstacles[k].bounding_box()
    mesh = np.full(count, -1)
    mesh[meshes] = range(len(meshes))
    return ObstacleArrays(kind, half, turn, at, box, mesh, *blocks_around(box))


def near_each_other(obstacles: Sequence[Obstacle]) -> Sequence[Obstacle]:
    """Return the obstacles of a world; many in an order in which neighbours follow each other.

    Halves of halves are near, as those of triangles in a tree are; up to ``MANY`` stay as they are.
    """
    if len(obstacles) <= MANY:
        return obstacles
    from kinolab.world.distances.triangle_tree import sort_by_leaf  # late: it knows this module

    box, order = obstacle_arrays(obstacles).box, np.arange(len(obstacles))
    sort_by_leaf(0.5 * (box[:, :3] + box[:, 3:]), order)
    return [obstacles[k] for k in order.tolist()]


def lowest_heights(shape: Shape, poses: Array) -> Array:
    """Give the lowest world z of a shape in [m] at poses (n, 3, 4) of its body, shape (n,)."""
    (kind, half), count = sizes(shape), len(poses)
    box = np.zeros((count, 6))
    enclose_all(
        np.full(count, int(kind)), np.tile(half, (count, 1)), *frame_in_world(shape, poses), box
    )
    return box[:, 2]


@kernel
def enclose(kind, half, turn, at, grow, box):  # type: ignore[no-untyped-def]
    """Write the axis-aligned box (6,) of a placed shape, ``grow`` larger on every side.

    Args:
        kind, half: The shape's kind and half sizes (3,) in [m].
        turn, at: Its rotation (3, 3) and centre (3,) in [m].
        grow: In [m].
        box: Lowest and highest x, y, z in [m], shape (6,); written.
    """
    for i in range(3):
        high = half_extent(kind, half, turn[i, 0], turn[i, 1], turn[i, 2]) + grow
        low = high  # of all others, which look the same from both sides
        if kind == HULL:
            low = half_extent(kind, half, -turn[i, 0], -turn[i, 1], -turn[i, 2]) + grow
        box[i] = at[i] - low
        box[i + 3] = at[i] + high


@kernel
def enclose_all(kind, half, turn, at, box):  # type: ignore[no-untyped-def]
    """Write the axis-aligned boxes of placed shapes, as ``enclose`` does for one.

    Args:
        kind, half: Kinds (n,) and half sizes (n, 3) in [m].
        turn, at: Rotations (n, 3, 3) and centres (n, 3) in [m].
        box: Lowest and highest x, y, z in [m], shape (n, 6); written.
    """
    for k in range(kind.shape[0]):
        enclose(kind[k], half[k], turn[k], at[k], 0.0, box[k])
