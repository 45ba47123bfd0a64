"""Gaps between a shape and triangles: cheap bounds, and the gap itself to those that are near."""

from __future__ import annotations

import math

from kinolab.numerics.jit import kernel
from kinolab.world.collision.gjk import TRIANGLE, Convex, box_gap, separation_within
from kinolab.world.collision.signed_distance import extent
from kinolab.world.support_functions import reach_along

TOUCHING_MARGIN = 3e-5  # [m] that is kept beside obstacles: FCL calls gaps of up to 1.7e-5 touching


@kernel
def mesh_clearance(shape, box, least, within, tree, scratch):  # type: ignore[no-untyped-def]
    """Bound the gap between a shape and all triangles, if it is below ``within``.

    Args:
        shape: ``Convex``.
        box: Lowest and highest x, y, z in [m], shape (6,).
        least, within: In [m]; a gap below ``least`` is told, and not by how much.
        tree: ``TriangleTree``.
        scratch: Memory with fields ``queue``, ``gaps``, ``corners`` and ``simplex``, as of
            ``Scratch``.
    """
    best, waiting, gaps = within, scratch.queue, scratch.gaps
    if tree.boxes.shape[0] == 0:
        return best
    waiting[0], gaps[0], left = 0, 0.0, 1
    while left > 0:
        left -= 1
        node = waiting[left]
        if gaps[left] >= best:
            continue
        if tree.child[node, 0] < 0:
            for t in range(tree.span[node, 0], tree.span[node, 1]):
                if plane_bound(shape, tree.planes[t]) >= best:
                    continue
                if own_bound(shape, tree.triangles[t]) >= best:
                    continue
                gap = to_triangle(shape, tree.triangles[t], least, best, scratch)
                best = min(best, gap)
                if best < least:
                    return best
            continue
        one, other = tree.child[node, 0], tree.child[node, 1]
        gap_one = box_bound(shape, box, tree.boxes[one])
        gap_other = box_bound(shape, box, tree.boxes[other])
        if gap_one < gap_other:  # the nearer one goes on top
            one, other, gap_one, gap_other = other, one, gap_other, gap_one
        waiting[left], gaps[left] = one, gap_one
        waiting[left + 1], gaps[left + 1] = other, gap_other
        left += 2
    return best


@kernel
def to_triangle(shape, triangle, least, enough, scratch):  # type: ignore[no-untyped-def]
    """Bound the gap between a shape and a triangle (9,).

    Args:
        shape: ``Convex``.
        triangle: Corners in [m], shape (9,).
        least, enough: In [m], as ``separation_within`` takes them.
        scratch: ``Scratch``.
    """
    corners = scratch.corners
    for i in range(9):
        corners[i % 3, i // 3] = triangle[i]
    other = Convex(TRIANGLE, shape.half, corners, triangle)
    return separation_within(shape, other, least, enough, scratch.simplex)


@kernel
def plane_bound(shape, plane):  # type: ignore[no-untyped-def]
    """Bound the gap between a shape and what lies in a plane (4,): unit normal and offset."""
    at = shape.at
    away = abs(plane[0] * at[0] + plane[1] * at[1] + plane[2] * at[2] - plane[3])
    return away - extent(shape, plane)


@kernel
def box_bound(shape, around, box):  # type: ignore[no-untyped-def]
    """Bound the gap between a shape and a box (6,): along the world's axes, and along its own."""
    turn, at = shape.turn, shape.at
    total = 0.0
    a, b, c = 0.5 * (box[3] - box[0]), 0.5 * (box[4] - box[1]), 0.5 * (box[5] - box[2])
    u, v, w = a + box[0] - at[0], b + box[1] - at[1], c + box[2] - at[2]
    for i in range(3):
        x, y, z = turn[0, i], turn[1, i], turn[2, i]
        away = abs(x * u + y * v + z * w) - abs(x) * a - abs(y) * b - abs(z) * c
        gap = max(away - reach_along(shape.kind, shape.half, i), 0.0)
        total += gap * gap
    return max(math.sqrt(total), box_gap(around, box))


@kernel
def own_bound(shape, triangle):  # type: ignore[no-untyped-def]
    """Bound the gap between a shape and a triangle (9,) along the shape's own axes."""
    turn, at = shape.turn, shape.at
    total = 0.0
    for i in range(3):
        x, y, z = turn[0, i], turn[1, i], turn[2, i]
        middle = x * at[0] + y * at[1] + z * at[2]
        one = x * triangle[0] + y * triangle[1] + z * triangle[2]
        two = x * triangle[3] + y * triangle[4] + z * triangle[5]
        three = x * triangle[6] + y * triangle[7] + z * triangle[8]
        low, high = min(one, two, three) - middle, max(one, two, three) - middle
        gap = max(max(low, -high) - reach_along(shape.kind, shape.half, i), 0.0)
        total += gap * gap
    return math.sqrt(total)
