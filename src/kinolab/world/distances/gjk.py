"""Distances that are proved: a lower bound on the gap between convex shapes and triangles.

FCL's own distances exceed the true ones by up to 2 mm in rare poses (a cylinder beside a box),
so nothing may be certified with them. Here every answer is the gap between two parallel planes
that keep the shapes apart: a valid bound whatever the search that found the direction did.

Source of the search: Gilbert, Johnson, Keerthi, IEEE Journal on Robotics and Automation 4(2),
1988; the stopping rule is van den Bergen's, Journal of Graphics Tools 4(2), 1999.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import allocating_kernel, kernel
from kinolab.world.shapes.support_functions import core_radius, core_support, dot, move_into_core

# numba would compile everything anew for a literal, here and where others are begun with one.
TRIANGLE = np.int64(-1)  # stands for a kind of shape; its corners are the columns of ``turn``
TOLERANCE = 1e-9  # [m] between the bound and a distance that is attained


class Convex(NamedTuple):
    """A placed convex shape, or a triangle; compiled code takes it as it is."""

    kind: int | np.int64  # of ``support_functions``, or TRIANGLE: columns of ``turn`` are corners
    half: Array  # (3,) half sizes in [m]; of a triangle unused
    turn: Array  # (3, 3) rotation into the world
    at: Array  # (3,) centre in the world in [m]; of a triangle any point of it


@kernel
def support_point(shape, n, local, point):  # type: ignore[no-untyped-def]
    """Write the farthest point (3,) along n of a core or a triangle; ``local`` is scratch (3,)."""
    kind, half, turn, at = shape
    if kind == TRIANGLE:
        best = -math.inf
        for corner in range(3):
            value = turn[0, corner] * n[0] + turn[1, corner] * n[1] + turn[2, corner] * n[2]
            if value > best:
                best = value
                for i in range(3):
                    point[i] = turn[i, corner]
        return
    for j in range(3):
        point[j] = turn[0, j] * n[0] + turn[1, j] * n[1] + turn[2, j] * n[2]
    core_support(kind, half, point, local)
    for i in range(3):
        point[i] = at[i] + turn[i, 0] * local[0] + turn[i, 1] * local[1] + turn[i, 2] * local[2]


@kernel
def move_into(shape, point, local):  # type: ignore[no-untyped-def]
    """Move a point (3,) into a core or a triangle, near to where it was; ``local`` is scratch (3,).

    Between two shapes of very different sizes that is a far better beginning than their centres.
    """
    kind, half, turn, at = shape
    if kind == TRIANGLE:
        for i in range(3):
            point[i] = at[i]
        return
    for j in range(3):
        local[j] = 0.0
        for i in range(3):
            local[j] += turn[i, j] * (point[i] - at[i])
    move_into_core(kind, half, local)
    for i in range(3):
        point[i] = at[i] + turn[i, 0] * local[0] + turn[i, 1] * local[1] + turn[i, 2] * local[2]


@kernel
def on_segment(a, b):  # type: ignore[no-untyped-def]
    """Return the point of a segment nearest to the origin, and a mask of the ends it needs."""
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    square = x * x + y * y + z * z
    along = -(a[0] * x + a[1] * y + a[2] * z)
    if along <= 0.0 or square == 0.0:
        return a[0], a[1], a[2], 1
    if along >= square:
        return b[0], b[1], b[2], 2
    t = along / square
    return a[0] + t * x, a[1] + t * y, a[2] + t * z, 3


@kernel
def on_triangle(a, b, c):  # type: ignore[no-untyped-def]
    """Return the point of a triangle nearest to the origin, and a mask of the corners it needs.

    Source: Ericson, Real-time collision detection, 2005, section 5.1.5.
    """
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    d1 = -(ux * a[0] + uy * a[1] + uz * a[2])
    d2 = -(vx * a[0] + vy * a[1] + vz * a[2])
    if d1 <= 0.0 and d2 <= 0.0:
        return a[0], a[1], a[2], 1
    d3 = -(ux * b[0] + uy * b[1] + uz * b[2])
    d4 = -(vx * b[0] + vy * b[1] + vz * b[2])
    if d3 >= 0.0 and d4 <= d3:
        return b[0], b[1], b[2], 2
    d5 = -(ux * c[0] + uy * c[1] + uz * c[2])
    d6 = -(vx * c[0] + vy * c[1] + vz * c[2])
    if d6 >= 0.0 and d5 <= d6:
        return c[0], c[1], c[2], 4
    at_c = d1 * d4 - d3 * d2
    if at_c <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        t = d1 / (d1 - d3)
        return a[0] + t * ux, a[1] + t * uy, a[2] + t * uz, 3
    at_b = d5 * d2 - d1 * d6
    if at_b <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        t = d2 / (d2 - d6)
        return a[0] + t * vx, a[1] + t * vy, a[2] + t * vz, 5
    at_a = d3 * d6 - d5 * d4
    if at_a <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return b[0] + t * (c[0] - b[0]), b[1] + t * (c[1] - b[1]), b[2] + t * (c[2] - b[2]), 6
    whole = at_a + at_b + at_c
    t, w = at_b / whole, at_c / whole
    return a[0] + t * ux + w * vx, a[1] + t * uy + w * vy, a[2] + t * uz + w * vz, 7


@kernel
def beyond(a, b, c, d):  # type: ignore[no-untyped-def]
    """Say whether the plane of a, b and c may have the origin on the other side than d."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    here = -(x * a[0] + y * a[1] + z * a[2])
    there = x * (d[0] - a[0]) + y * (d[1] - a[1]) + z * (d[2] - a[2])
    return not here * there > 0.0


@kernel
def closest_on_simplex(simplex, count, v):  # type: ignore[no-untyped-def]
    """Write the point v of a simplex nearest to the origin and keep only the corners it needs.

    Returns:
        The number of corners kept, at the front of ``simplex`` (4, 3).
    """
    kept = 1
    if count == 1:
        v[0], v[1], v[2] = simplex[0, 0], simplex[0, 1], simplex[0, 2]
    elif count == 2:
        v[0], v[1], v[2], kept = on_segment(simplex[0], simplex[1])
    elif count == 3:
        v[0], v[1], v[2], kept = on_triangle(simplex[0], simplex[1], simplex[2])
    else:
        best, kept = math.inf, 15
        v[0], v[1], v[2] = 0.0, 0.0, 0.0
        for left_out in range(4):
            i = 1 if left_out == 0 else 0
            j = 2 if left_out <= 1 else 1
            k = 3 if left_out <= 2 else 2
            a, b, c = simplex[i], simplex[j], simplex[k]
            if not beyond(a, b, c, simplex[left_out]):
                continue
            x, y, z, mask = on_triangle(a, b, c)
            if x * x + y * y + z * z < best:
                best = x * x + y * y + z * z
                v[0], v[1], v[2] = x, y, z
                kept = (mask & 1) << i | (mask >> 1 & 1) << j | (mask >> 2 & 1) << k
    size = 0
    for i in range(count):
        if kept >> i & 1:
            for k in range(3):
                simplex[size, k] = simplex[i, k]
            size += 1
    return size


@kernel
def separation_within(one, other, least, enough, scratch, precise=math.inf):  # type: ignore[no-untyped-def]
    """Bound the gap between two convex things from below, to 1e-9 m of the truth where it is free.

    Args:
        one, other: ``Convex``.
        least: In [m]; whether the gap is smaller than this is told, and not by how much.
        enough: In [m]; a bound of this size need not be improved.
        scratch: Memory, shape (9, 3).
        precise: In [m]; the bound of a larger gap may be short by a tenth of itself.

    Returns:
        A distance in [m] that the true one is not smaller than; 0 where nothing is proved.
    """
    simplex, v, away = scratch[:4], scratch[4], scratch[5]
    a, b, local = scratch[6], scratch[7], scratch[8]
    for k in range(3):
        b[k] = one.at[k]
    move_into(other, b, local)
    for k in range(3):
        a[k] = b[k]
    move_into(one, a, local)
    for k in range(3):
        v[k] = a[k] - b[k]
    count, bound = 0, 0.0
    swollen = (0.0 if one.kind == TRIANGLE else core_radius(one.kind, one.half)) + (
        0.0 if other.kind == TRIANGLE else core_radius(other.kind, other.half)
    )
    for _ in range(64):  # iterations at most
        distance = math.sqrt(dot(v, v))
        if distance <= TOLERANCE or count == 4:
            break
        for k in range(3):
            away[k] = -v[k]
        support_point(one, away, local, a)
        support_point(other, v, local, b)
        bound = max(bound, (dot(v, a) - dot(v, b)) / distance)
        gap = bound - swollen
        if distance - bound <= TOLERANCE or gap >= enough:
            break
        # of a gap, by which its bound may be short where that does no harm
        if gap >= precise and distance - bound <= 0.1 * gap:
            break
        if distance - swollen < least:
            break  # the gap is no larger than the distance of two points
        for k in range(3):
            simplex[count, k] = a[k] - b[k]
        count = closest_on_simplex(simplex, count + 1, v)
    return max(bound - swollen, 0.0)


@allocating_kernel
def separation(one, other):  # type: ignore[no-untyped-def]
    """Bound a gap as ``separation_within`` does, as closely as it can."""
    return separation_within(one, other, 0.0, math.inf, np.empty((9, 3)))


@kernel
def box_gap(a, b):  # type: ignore[no-untyped-def]
    """Give the distance between two axis-aligned boxes (6,), a bound on what is in them."""
    total = 0.0
    for i in range(3):
        gap = max(a[i] - b[i + 3], b[i] - a[i + 3], 0.0)
        total += gap * gap
    return math.sqrt(total)
