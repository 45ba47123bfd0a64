"""Gaps between a shape and triangles: cheap bounds, and the gap itself to those that are near.

Bounds are worked out in single precision, for all boxes of a group and all triangles of a leaf at
once, and compared with limits that are larger by what rounding may have changed.
"""

from __future__ import annotations

import numpy as np

from kinolab.numerics.jit import kernel
from kinolab.numerics.simd import (
    BEFORE_ALL,
    LANES,
    NOTHING,
    bits_of,
    load,
    maximum,
    minimum,
    next_key,
    ranked,
    spread,
    store,
)
from kinolab.world.distances.gjk import TRIANGLE, Convex, separation_within
from kinolab.world.distances.signed_distance import extent
from kinolab.world.distances.triangle_tree import NOWHERE
from kinolab.world.shapes.support_functions import reach_along

TOUCHING_MARGIN = 3e-5  # [m] that is kept beside obstacles: FCL calls gaps of up to 1.7e-5 touching
FARTHEST_SQUARE = 1e-1 * float(NOWHERE) ** 2  # [m^2] beyond which there is no box
BOX, AXES, CENTRE, REACH = 0, 6, 15, 18  # where they begin in ``Traversal.shape``
HALF = np.float32(0.5)


@kernel
def mesh_clearance(shape, box, least, within, tree, scratch):  # type: ignore[no-untyped-def]
    """Bound the gap between a shape and all triangles, if it is below ``within``.

    Args:
        shape: ``Convex``.
        box: Lowest and highest x, y, z in [m], shape (6,).
        least, within: In [m]; a gap below ``least`` is told, and not by how much.
        tree: ``TriangleTree``.
        scratch: Memory with fields ``traversal``, ``corners`` and ``simplex``, as of ``Scratch``.
    """
    best, traversal = within, scratch.traversal
    if tree.corners.shape[0] == 0:
        return best
    slack = begin_search(shape, box, tree, traversal)
    while True:
        leaf = next_leaf(limit_of(best, slack), tree, traversal)
        if leaf < 0:
            return best
        near = ranked(triangle_bounds(leaf, tree, traversal.shape))
        key = next_key(near, BEFORE_ALL)
        while key & -LANES < bits_of(limit_of(best, slack)):
            t = leaf * LANES + (key & (LANES - 1))
            if plane_bound(shape, tree.planes[t]) < best:
                ball = tree.ball[t]
                gap = to_triangle(shape, tree.triangles[t], least + ball, best + ball, scratch)
                best = min(best, gap - ball)
                if best < least:
                    return best
            key = next_key(near, key)


@kernel
def begin_search(shape, box, tree, traversal):  # type: ignore[no-untyped-def]
    """Begin a search for the triangles near a shape; return what rounding may change, in [m].

    Args:
        shape: ``Convex``.
        box: Lowest and highest x, y, z in [m], shape (6,).
        tree: ``TriangleTree`` with at least one triangle.
        traversal: ``Traversal``; written.
    """
    at, turn, origin, found, farthest = shape.at, shape.turn, tree.origin, traversal.shape, 0.0
    for i in range(3):
        for end in (i, i + 3):
            place = box[end] - origin[i]
            found[BOX + end] = place
            farthest = max(farthest, abs(place))
        centre = 0.0
        for j in range(3):
            found[AXES + 3 * i + j] = turn[j, i]
            centre += turn[j, i] * (at[j] - origin[j])
        found[CENTRE + i] = centre
        found[REACH + i] = reach_along(shape.kind, shape.half, i)
    top = tree.first.shape[0] + 1  # a layer with one box, which holds all others
    for lane in range(LANES):
        traversal.keys[top, lane] = 0.0 if lane == 0 else NOWHERE * NOWHERE
    store(traversal.keys, (top, 0), ranked(load(traversal.keys, (top, 0))))
    traversal.last[top], traversal.path[top], traversal.layer[0] = BEFORE_ALL, 0, top
    # of the farthest coordinate: what single precision may change, with some to spare
    return 2e-6 * (farthest + tree.extent)


@kernel
def limit_of(gap, slack):  # type: ignore[no-untyped-def]
    """Return the square in single precision that no bound reaches of what is within a gap in [m].

    Args:
        gap: In [m].
        slack: What rounding may change, in [m].
    """
    reach = max(gap, 0.0) + slack
    return np.float32(min(reach * reach, FARTHEST_SQUARE))


@kernel
def next_leaf(limit, tree, traversal):  # type: ignore[no-untyped-def]
    """Return the next leaf that may be near, the nearest of a group first; -1 if there is none.

    Args:
        limit: As ``limit_of`` returns it.
        tree: ``TriangleTree``.
        traversal: ``Traversal``, as ``begin_search`` or this function left it; written.
    """
    keys, last, path, first = traversal.keys, traversal.last, traversal.path, tree.first
    layer, top = traversal.layer[0], first.shape[0] + 1
    while layer <= top:
        key = next_key(load(keys, (layer, 0)), last[layer])
        if key & -LANES >= bits_of(limit):
            layer += 1
            continue
        last[layer] = key
        below = path[layer] * LANES + (key & (LANES - 1))
        if layer == 1:
            traversal.layer[0] = layer
            return below
        layer -= 1
        group = first[layer - 1] + below
        store(keys, (layer, 0), ranked(box_bounds(group, tree, traversal.shape)))
        last[layer], path[layer] = BEFORE_ALL, below
    traversal.layer[0] = layer
    return -1


@kernel
def box_bounds(group, tree, shape):  # type: ignore[no-untyped-def]
    """Bound the squared gaps between a shape and a group's boxes, in [m^2].

    The boxes are compared along the world's axes and along the shape's own; the larger bound holds.

    Args:
        group: Number of the group.
        tree: ``TriangleTree``.
        shape: ``Traversal.shape``.
    """
    boxes, nothing, half = tree.boxes, spread(NOTHING), spread(HALF)
    x_low, x_high = load(boxes, (group, 0, 0, 0)), load(boxes, (group, 1, 0, 0))
    y_low, y_high = load(boxes, (group, 0, 1, 0)), load(boxes, (group, 1, 1, 0))
    z_low, z_high = load(boxes, (group, 0, 2, 0)), load(boxes, (group, 1, 2, 0))
    x_gap = maximum(x_low - spread(shape[BOX + 3]), spread(shape[BOX]) - x_high)
    y_gap = maximum(y_low - spread(shape[BOX + 4]), spread(shape[BOX + 1]) - y_high)
    z_gap = maximum(z_low - spread(shape[BOX + 5]), spread(shape[BOX + 2]) - z_high)
    x_gap, y_gap, z_gap = maximum(x_gap, nothing), maximum(y_gap, nothing), maximum(z_gap, nothing)
    x, y, z = half * (x_low + x_high), half * (y_low + y_high), half * (z_low + z_high)
    a, b, c = x_high - x, y_high - y, z_high - z
    own = nothing
    for i in range(3):
        u, v = spread(shape[AXES + 3 * i]), spread(shape[AXES + 3 * i + 1])
        w = spread(shape[AXES + 3 * i + 2])
        away = magnitude(u * x + v * y + w * z - spread(shape[CENTRE + i]))
        reach = magnitude(u) * a + magnitude(v) * b + magnitude(w) * c + spread(shape[REACH + i])
        gap = maximum(away - reach, nothing)
        own += gap * gap
    return maximum(x_gap * x_gap + y_gap * y_gap + z_gap * z_gap, own)


@kernel
def triangle_bounds(leaf, tree, shape):  # type: ignore[no-untyped-def]
    """Bound the squared gaps between a shape and a leaf's triangles along the shape's own axes.

    Args:
        leaf: Number of the leaf.
        tree: ``TriangleTree``.
        shape: ``Traversal.shape``.
    """
    corners, nothing, ball = tree.corners, spread(NOTHING), load(tree.balls, (leaf, 0))
    total = nothing
    for i in range(3):
        u, v = spread(shape[AXES + 3 * i]), spread(shape[AXES + 3 * i + 1])
        w = spread(shape[AXES + 3 * i + 2])
        one = along(leaf, 0, corners, u, v, w)
        two = along(leaf, 3, corners, u, v, w)
        three = along(leaf, 6, corners, u, v, w)
        low, high = minimum(minimum(one, two), three), maximum(maximum(one, two), three)
        centre = spread(shape[CENTRE + i])
        reach = spread(shape[REACH + i]) + ball
        gap = maximum(maximum(low - centre, centre - high) - reach, nothing)
        total += gap * gap
    return total


@kernel
def along(leaf, corner, corners, u, v, w):  # type: ignore[no-untyped-def]
    """Return how far a corner of each of a leaf's triangles is along a vector, in [m].

    Args:
        leaf: Number of the leaf.
        corner: Row of the corner's x in ``corners``.
        corners: As of ``TriangleTree``.
        u, v, w: Of the unit vector, in all lanes.
    """
    return (
        u * load(corners, (leaf, corner, 0))
        + v * load(corners, (leaf, corner + 1, 0))
        + w * load(corners, (leaf, corner + 2, 0))
    )


@kernel
def magnitude(value):  # type: ignore[no-untyped-def]
    """Return absolute values."""
    return maximum(value, spread(NOTHING) - value)


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
    above = plane[0] * at[0] + plane[1] * at[1] + plane[2] * at[2] - plane[3]
    return abs(above) - extent(shape, plane, -1.0 if above > 0.0 else 1.0)
