"""A tree of boxes around the triangles of a world's meshes: which are near, without a look at all.

As many boxes as a processor handles at once belong to one group, and as many triangles to one leaf.
Groups and leaves are full but for the last ones, so that numbers tell what is below a group.

Source: Goldsmith, Salmon, Automatic creation of object hierarchies for ray tracing, IEEE Computer
Graphics and Applications 7(5), 1987; Wald, Benthin, Boulos, Getting rid of packets: efficient SIMD
single-ray traversal using multi-branching BVHs, IEEE Symposium on Interactive Ray Tracing, 2008.
Here it is split at medians, which need no costs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import allocating_kernel
from kinolab.numerics.neighbours.selection import partition_median
from kinolab.numerics.simd import LANES
from kinolab.world.distances.triangle_grid import mesh_grid
from kinolab.world.obstacles.kept_together import kept_together
from kinolab.world.obstacles.obstacle import Obstacle

MAX_LAYERS = 9  # of groups, and one above them
NOWHERE = np.float32(1e15)  # [m] where a box is that is none

Lanes = NDArray[np.float32]


class TriangleTree(NamedTuple):
    """Boxes of boxes of triangles, for compiled code.

    Leaf k has the LANES triangles from LANES * k on; the last triangle fills the last leaf up.
    Group k of a layer has the LANES groups of the layer below from LANES * k on; in the lowest
    layer, leaves.
    """

    triangles: Array  # (leaves * LANES, 9) corners in [m]
    planes: Array  # (leaves * LANES, 4) unit normals and offsets in [m]; zeros without an area
    leaf_boxes: Array  # (leaves, 6): lowest and highest x, y, z in [m]
    corners: Lanes  # (leaves, 9, LANES) of the triangles, from ``origin``
    boxes: Lanes  # (groups, 2, 3, LANES): lowest and highest x, y, z from ``origin``
    first: Integers  # (layers,) group of each layer, the lowest layer first
    origin: Array  # (3,) the middle of all, in [m]
    extent: float  # [m] of the largest side of all
    ball: Array  # (leaves * LANES,) [m] by which things are larger all round than their triangles
    balls: Lanes  # (leaves, LANES) the same


class Traversal(NamedTuple):
    """How far a search of a tree is: memory of one thread."""

    keys: Annotated[Lanes, MAX_LAYERS, LANES]  # squared distances and lanes of a group
    last: Annotated[Integers, MAX_LAYERS]  # key of the lane that was searched last
    path: Annotated[Integers, MAX_LAYERS]  # the group
    layer: Annotated[Integers, 1]  # from which the search goes on
    shape: Annotated[Lanes, 21]  # box, axes, centre along these and reach along these


def mesh_tree(obstacles: Sequence[Obstacle]) -> TriangleTree:
    """Return the tree of the triangles of all meshes among obstacles, in ``mesh_grid``'s order."""
    return _tree([obstacle for obstacle in obstacles if obstacle.primitive is None])


def triangle_tree(triangles: Array, ball: Array | None = None) -> TriangleTree:
    """Build the tree of triangles (m, 9) and of what is round about them, by (m,) in [m]."""
    order = np.arange(len(triangles))
    sort_by_leaf(triangles.reshape(-1, 3, 3).mean(axis=1), order)
    leaves = -(-len(order) // LANES)
    rows = np.append(order, order[-1:].repeat(-len(order) % LANES))
    kept, around = triangles[rows], np.zeros(len(rows)) if ball is None else ball[rows]
    points = kept.reshape(leaves, 3 * LANES, 3)
    wide = around.reshape(leaves, LANES).repeat(3, axis=1)[:, :, None]
    leaf_boxes = np.concatenate([(points - wide).min(axis=1), (points + wide).max(axis=1)], axis=1)
    low = leaf_boxes[:, :3].min(axis=0) if leaves else np.zeros(3)
    high = leaf_boxes[:, 3:].max(axis=0) if leaves else np.zeros(3)
    origin = 0.5 * (low + high)
    corners = (points.reshape(leaves, LANES, 9) - np.tile(origin, 3)).transpose(0, 2, 1)
    boxes, first = _groups(leaf_boxes - np.tile(origin, 2))
    return TriangleTree(
        kept,
        _planes(kept),
        leaf_boxes,
        np.ascontiguousarray(corners, np.float32),
        boxes,
        first,
        origin,
        float((high - low).max()),
        around,
        around.reshape(leaves, LANES).astype(np.float32),
    )


def _tree_of(meshes: Sequence[Obstacle]) -> TriangleTree:
    grid = mesh_grid(meshes)
    return triangle_tree(grid.triangles, grid.ball)


_tree = kept_together(_tree_of)


def _groups(boxes: Array) -> tuple[Lanes, Integers]:
    """Return the boxes of all groups above leaves' boxes (leaves, 6), and each layer's first."""
    layers: list[Array] = []
    while len(boxes) > 1:
        count = -(-len(boxes) // LANES)
        lanes = np.full((count * LANES, 6), NOWHERE, dtype=float)
        lanes[: len(boxes)] = boxes
        layers.append(lanes.reshape(count, LANES, 2, 3).transpose(0, 2, 3, 1))
        begin = LANES * np.arange(count)
        low, high = np.minimum.reduceat(boxes, begin), np.maximum.reduceat(boxes, begin)
        boxes = np.concatenate([low[:, :3], high[:, 3:]], axis=1)
    counts = [len(layer) for layer in layers]
    together = np.concatenate([np.zeros((0, 2, 3, LANES)), *layers])
    return together.astype(np.float32), np.cumsum([0, *counts], dtype=np.int64)[:-1]


def _planes(triangles: Array) -> Array:
    """Return unit normals and offsets (m, 4); zeros, which bound nothing, of what is a line.

    Where corners are collinear but for rounding, the cross product is rounding, too.
    """
    corner = triangles.reshape(-1, 3, 3)
    first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    normal = np.cross(first, second)
    size, a, b = (np.linalg.norm(v, axis=1, keepdims=True) for v in (normal, first, second))
    # sine of a corner: flatter triangles are taken for lines, which have no plane
    unit = np.divide(normal, size, out=np.zeros_like(normal), where=size > 1e-6 * a * b)
    return np.column_stack([unit, (unit * corner[:, 0]).sum(axis=1)])


@allocating_kernel
def sort_by_leaf(middle, order):  # type: ignore[no-untyped-def]
    """Sort triangles so that those of a leaf, and the leaves of a group, are near each other.

    Args:
        middle: Centroids in [m], shape (m, 3).
        order: Triangles, shape (m,); written.
    """
    ranges, left = np.empty((80, 2), np.int64), 1  # that wait while triangles are sorted, at most
    ranges[0, 0], ranges[0, 1] = 0, order.shape[0]
    while left > 0:
        left -= 1
        first, last = ranges[left, 0], ranges[left, 1]
        if last - first <= LANES:
            continue
        size = LANES  # of the largest parts that are full
        while size * LANES < last - first:
            size *= LANES
        half = first + -(-(last - first) // size) // 2 * size
        axis, widest = 0, -1.0
        for i in range(3):
            low = high = middle[order[first], i]
            for at in range(first, last):
                low, high = min(low, middle[order[at], i]), max(high, middle[order[at], i])
            if high - low > widest:
                axis, widest = i, high - low
        partition_median(middle, axis, order, first, last - 1, half)
        ranges[left, 0], ranges[left, 1] = first, half
        ranges[left + 1, 0], ranges[left + 1, 1] = half, last
        left += 2
