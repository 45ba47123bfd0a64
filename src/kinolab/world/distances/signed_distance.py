"""Signed gaps between convex things, and the planes that tell them apart.

For any unit normal the distance between two parallel planes that touch the things from opposite
sides is no larger than their gap; for the best normal it is the gap, and inside an overlap it is
the least way out, taken negative. So one formula serves both, and its derivative is that of the
planes with the normal held: no points of contact are needed.

Source: Schulman and others, Motion planning with sequential convex optimization and convex
collision checking, IJRR 33(9), 2014; Danskin, The theory of max-min, 1966 (the derivative).
"""

from __future__ import annotations

import math

from kinolab.numerics.jit import kernel
from kinolab.world.distances.gjk import TRIANGLE, separation_within
from kinolab.world.shapes.support_functions import half_extent


@kernel
def extent(shape, n, sign=1.0):  # type: ignore[no-untyped-def]
    """Give the reach in [m] of a shape from its centre along n (3,), or against it by the sign."""
    turn = shape.turn
    x = n[0] * turn[0, 0] + n[1] * turn[1, 0] + n[2] * turn[2, 0]
    y = n[0] * turn[0, 1] + n[1] * turn[1, 1] + n[2] * turn[2, 1]
    z = n[0] * turn[0, 2] + n[1] * turn[1, 2] + n[2] * turn[2, 2]
    return half_extent(shape.kind, shape.half, sign * x, sign * y, sign * z)


@kernel
def highest(shape, n):  # type: ignore[no-untyped-def]
    """Give the farthest offset of a shape or a triangle along n (3,), in [m]."""
    turn, at = shape.turn, shape.at
    if shape.kind == TRIANGLE:
        best = -math.inf
        for c in range(3):
            best = max(best, n[0] * turn[0, c] + n[1] * turn[1, c] + n[2] * turn[2, c])
        return best
    return n[0] * at[0] + n[1] * at[1] + n[2] * at[2] + extent(shape, n)


@kernel
def gap_along(shape, other, n):  # type: ignore[no-untyped-def]
    """Give the distance of the planes with normal n, which points from the other one to a shape."""
    at = shape.at
    lowest = n[0] * at[0] + n[1] * at[1] + n[2] * at[2] - extent(shape, n, -1.0)
    return lowest - highest(other, n)


@kernel
def signed_gap(shape, other, enough, scratch, n):  # type: ignore[no-untyped-def]
    """Return the signed gap in [m] between a shape and another one or a triangle; write n (3,).

    Inside an overlap the best of a few normals is taken: those of faces and of pairs of edges,
    which is exact between boxes and triangles, and the line between the centres.

    Args:
        shape, other: ``Convex``.
        enough: In [m]; a gap of this size is only bounded from below, and has no normal.
        scratch: Memory, shape (9, 3).
        n: Unit normal from the other one to the shape, shape (3,); written.
    """
    bound = separation_within(shape, other, -math.inf, enough, scratch)
    if bound >= enough:
        return bound
    v = scratch[4]
    length = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    if length > 1e-7:  # [m] between cores from which on the search's direction can be trusted
        for i in range(3):
            n[i] = v[i] / length
        return gap_along(shape, other, n)
    return overlap(shape, other, scratch, n)


@kernel
def overlap(shape, other, scratch, n):  # type: ignore[no-untyped-def]
    """Return the largest gap along normals that may be the best one where things overlap."""
    best, corners = -math.inf, other.kind == TRIANGLE
    trial, one, two = scratch[5], scratch[6], scratch[7]
    for a in range(-1, 3):
        for b in range(-1, 3):
            axis_of(a, False, shape.turn, one)
            axis_of(b, corners, other.turn, two)
            for i in range(3):
                if a < 0 and b < 0:
                    trial[i] = shape.at[i] - other.at[i]
                elif b < 0 or a < 0:
                    trial[i] = one[i] if b < 0 else two[i]
            if a >= 0 and b >= 0:
                across(one, two, trial)
            best = better(best, trial, shape, other, n)
    if corners:
        axis_of(0, True, other.turn, one)
        axis_of(1, True, other.turn, two)
        across(one, two, trial)
        best = better(best, trial, shape, other, n)
    return best


@kernel
def across(a, b, out):  # type: ignore[no-untyped-def]
    """Write the cross product of two vectors (3,)."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] = a[j] * b[k] - a[k] * b[j]


@kernel
def axis_of(i, corners, columns, out):  # type: ignore[no-untyped-def]
    """Write column i, an axis of a shape; or where the columns are corners, an edge."""
    for k in range(3):
        if 0 <= i < 3:
            out[k] = columns[k, (i + 1) % 3] - columns[k, i] if corners else columns[k, i]


@kernel
def better(best, trial, shape, other, n):  # type: ignore[no-untyped-def]
    """Return the gap along a trial direction or its opposite if it is larger; write n then.

    Args:
        best: The largest gap so far in [m].
        trial: Direction of any length, shape (3,); made a unit vector.
        shape, other: ``Convex``.
        n: Unit normal, shape (3,); written where the gap is larger.
    """
    length = math.sqrt(trial[0] * trial[0] + trial[1] * trial[1] + trial[2] * trial[2])
    if not length > 1e-6:  # length of a cross product of unit vectors that has no direction
        return best
    for sign in (1.0, -1.0):
        for i in range(3):
            trial[i] *= sign / length
        length = 1.0
        gap = gap_along(shape, other, trial)
        if gap > best:
            best = gap
            for i in range(3):
                n[i] = trial[i]
    return best
