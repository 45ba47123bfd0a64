"""A tree of boxes around the triangles of a world's meshes: which are near, without a look at all.

Source: Goldsmith, Salmon, Automatic creation of object hierarchies for ray tracing, IEEE Computer
Graphics and Applications 7(5), 1987; here split at the median, which needs no costs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import allocating_kernel
from kinolab.numerics.neighbours.selection import partition_median
from kinolab.world.collision.triangle_grid import Integers, mesh_grid
from kinolab.world.kept_together import KeptTogether
from kinolab.world.obstacle import Obstacle

LEAF_SIZE = 4  # triangles in a leaf at most
STACK_SIZE = 64  # nodes that wait at most in a search, at a tree's depth


class TriangleTree(NamedTuple):
    """Boxes of boxes of triangles, for compiled code; the first box holds all the others."""

    triangles: Array  # (m, 9) corners in [m], leaf by leaf
    planes: Array  # (m, 4) unit normals and offsets in [m]; zeros where a triangle has no area
    boxes: Array  # (nodes, 6): lowest and highest x, y, z
    child: Integers  # (nodes, 2) the two parts; of a leaf -1 and nothing
    span: Integers  # (nodes, 2) the triangles below, one past the last


def mesh_tree(obstacles: Sequence[Obstacle]) -> TriangleTree:
    """Return the tree of the triangles of all meshes among obstacles, in ``mesh_grid``'s order."""
    return _tree([obstacle for obstacle in obstacles if obstacle.primitive is None])


def triangle_tree(triangles: Array) -> TriangleTree:
    """Build the tree of triangles (m, 9)."""
    count = len(triangles)
    order = np.arange(count)
    middle = triangles.reshape(-1, 3, 3).mean(axis=1)
    most = max(2 * count, 1)
    boxes, child, span = np.zeros((most, 6)), np.full((most, 2), -1), np.zeros((most, 2), np.int64)
    nodes = build(triangles, middle, order, boxes, child, span) if count else 0
    kept = np.ascontiguousarray(triangles[order])
    return TriangleTree(
        kept, _planes(kept), boxes[:nodes].copy(), child[:nodes].copy(), span[:nodes].copy()
    )


_tree = KeptTogether(lambda meshes: triangle_tree(mesh_grid(meshes).triangles))


def _planes(triangles: Array) -> Array:
    corner = triangles.reshape(-1, 3, 3)
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    unit = np.divide(normal, size, out=np.zeros_like(normal), where=size > 0)
    return np.column_stack([unit, (unit * corner[:, 0]).sum(axis=1)])


@allocating_kernel
def build(triangles, middle, order, boxes, child, span):  # type: ignore[no-untyped-def]
    """Fill a tree's arrays level by level and sort ``order`` on the way; return its size.

    Args:
        triangles, middle: Corners (m, 9) and centroids (m, 3) in [m].
        order: Triangles leaf by leaf, shape (m,); written.
        boxes, child, span: Of ``TriangleTree``, shapes (nodes, 6), (nodes, 2), (nodes, 2); written.
    """
    nodes, here = 1, 0
    low, high = np.empty(3), np.empty(3)
    span[0, 0], span[0, 1] = 0, order.shape[0]
    while here < nodes:
        first, last = span[here, 0], span[here, 1]
        for i in range(3):
            boxes[here, i], boxes[here, i + 3] = math.inf, -math.inf
            low[i], high[i] = math.inf, -math.inf
        for at in range(first, last):
            for i in range(3):
                low[i] = min(low[i], middle[order[at], i])
                high[i] = max(high[i], middle[order[at], i])
            for i in range(9):
                value = triangles[order[at], i]
                boxes[here, i % 3] = min(boxes[here, i % 3], value)
                boxes[here, i % 3 + 3] = max(boxes[here, i % 3 + 3], value)
        if last - first > LEAF_SIZE:
            axis = 0
            for i in range(1, 3):
                if high[i] - low[i] > high[axis] - low[axis]:
                    axis = i
            half = (first + last) // 2
            partition_median(middle, axis, order, first, last - 1, half)
            child[here, 0], child[here, 1] = nodes, nodes + 1
            span[nodes, 0], span[nodes, 1] = first, half
            span[nodes + 1, 0], span[nodes + 1, 1] = half, last
            nodes += 2
        here += 1
    return nodes
