"""Distances that are proved: a lower bound on the gap between convex shapes and triangles.

FCL's own distances exceed the true ones by up to 2 mm in rare poses (a cylinder beside a box),
so nothing may be certified with them. Here every answer is the gap between two parallel planes
that keep the shapes apart: a valid bound whatever the search that found the direction did.

Source of the search: Gilbert, Johnson, Keerthi, IEEE Journal on Robotics and Automation 4(2),
1988; the stopping rule is van den Bergen's, Journal of Graphics Tools 4(2), 1999.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from kinolab.world.support import core_radius, core_support, dot

TRIANGLE = -1  # stands for a kind of shape; its corners are the columns of ``turn``
TOLERANCE = 1e-9  # [m] between the bound and a distance that is attained
MAX_ROUNDS = 64


@numba.njit(cache=True, error_model="numpy")
def farthest(kind, half, turn, at, n, local, point):  # type: ignore[no-untyped-def]
    """Write the farthest point (3,) along n of a core or a triangle; ``local`` is scratch (3,)."""
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


@numba.njit(cache=True, error_model="numpy")
def solve(G, b, weights):  # type: ignore[no-untyped-def]
    """Solve G weights = b (3, 3) by Cramer's rule; False where G is singular to rounding."""
    c0 = G[1, 1] * G[2, 2] - G[1, 2] * G[2, 1]
    c1 = G[1, 2] * G[2, 0] - G[1, 0] * G[2, 2]
    c2 = G[1, 0] * G[2, 1] - G[1, 1] * G[2, 0]
    det = G[0, 0] * c0 + G[0, 1] * c1 + G[0, 2] * c2
    if det <= 1e-14 * G[0, 0] * G[1, 1] * G[2, 2]:
        return False
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        # G is symmetric: row k of its adjugate.
        weights[k] = (
            b[k] * (G[i, i] * G[j, j] - G[i, j] * G[j, i])
            + b[i] * (G[k, j] * G[j, i] - G[k, i] * G[j, j])
            + b[j] * (G[k, i] * G[i, j] - G[k, j] * G[i, i])
        ) / det
    return True


@numba.njit(cache=True, error_model="numpy")
def edge_product(simplex, i, j, base):  # type: ignore[no-untyped-def]
    """Multiply the edges from corner ``base`` to the corners i and j."""
    total = 0.0
    for k in range(3):
        total += (simplex[i, k] - simplex[base, k]) * (simplex[j, k] - simplex[base, k])
    return total


@numba.njit(cache=True, error_model="numpy")
def face_point(simplex, count, mask, x, G, b, weights):  # type: ignore[no-untyped-def]
    """Write the point x nearest to the origin in the plane of the corners that ``mask`` names.

    Returns:
        Whether it lies on the face itself; False as well where the face has no area.
    """
    base = 0
    while not mask >> base & 1:
        base += 1
    for i in range(3):
        uses_i = i + 1 > base and i + 1 < count and mask >> (i + 1) & 1
        for j in range(3):
            uses_j = j + 1 > base and j + 1 < count and mask >> (j + 1) & 1
            G[i, j] = 1.0 if i == j else 0.0
            if uses_i and uses_j:
                G[i, j] = edge_product(simplex, i + 1, j + 1, base)
        b[i] = 0.0
        if uses_i:
            for k in range(3):
                b[i] -= (simplex[i + 1, k] - simplex[base, k]) * simplex[base, k]
    if not solve(G, b, weights):
        return False
    for k in range(3):
        x[k] = simplex[base, k]
        for i in range(3):
            x[k] += weights[i] * (simplex[i + 1, k] - simplex[base, k])
    least = min(weights[0], weights[1], weights[2])
    return least >= 0.0 and weights[0] + weights[1] + weights[2] <= 1.0


@numba.njit(cache=True, error_model="numpy")
def nearest(simplex, count, v, x, G, b, weights):  # type: ignore[no-untyped-def]
    """Write the point v of a simplex nearest to the origin and keep only the corners it needs.

    Tries every face of the simplex (4, 3), at most 15, of which one holds the nearest point. The
    arrays after v are scratch.

    Returns:
        The number of corners kept, at the front of ``simplex``.
    """
    best, kept, size = math.inf, 0, 0
    for mask in range(1, 1 << count):
        if face_point(simplex, count, mask, x, G, b, weights) and dot(x, x) < best:
            best, kept = dot(x, x), mask
            for k in range(3):
                v[k] = x[k]
    for i in range(count):
        if kept >> i & 1:
            for k in range(3):
                simplex[size, k] = simplex[i, k]
            size += 1
    return size


@numba.njit(cache=True, error_model="numpy")
def separation(kind_a, half_a, turn_a, at_a, kind_b, half_b, turn_b, at_b):  # type: ignore[no-untyped-def]
    """Bound the gap between two convex things from below, to 1e-9 m of the truth where it is free.

    Args:
        kind_a: A kind of shape, or TRIANGLE: then ``turn_a`` has its corners as columns.
        half_a: Half sizes (3,) in [m].
        turn_a: Rotation into the world (3, 3).
        at_a: Centre in the world (3,); for a triangle, any point of it.
        kind_b, half_b, turn_b, at_b: The other one.

    Returns:
        A distance in [m] that the true one is not smaller than; 0 where nothing is proved.
    """
    simplex, G, scratch = np.zeros((4, 3)), np.zeros((3, 3)), np.zeros((8, 3))
    v, away, a, b = scratch[0], scratch[1], scratch[2], scratch[3]
    x, rhs, weights, local = scratch[4], scratch[5], scratch[6], scratch[7]
    for k in range(3):
        v[k] = at_a[k] - at_b[k]
    count, bound = 0, 0.0
    for _ in range(MAX_ROUNDS):
        distance = math.sqrt(dot(v, v))
        if distance <= TOLERANCE or count == 4:
            break
        for k in range(3):
            away[k] = -v[k]
        farthest(kind_a, half_a, turn_a, at_a, away, local, a)
        farthest(kind_b, half_b, turn_b, at_b, v, local, b)
        bound = max(bound, (dot(v, a) - dot(v, b)) / distance)
        if distance - bound <= TOLERANCE:
            break
        for k in range(3):
            simplex[count, k] = a[k] - b[k]
        count = nearest(simplex, count + 1, v, x, G, rhs, weights)
    swollen = (0.0 if kind_a == TRIANGLE else core_radius(kind_a, half_a)) + (
        0.0 if kind_b == TRIANGLE else core_radius(kind_b, half_b)
    )
    return max(bound - swollen, 0.0)


@numba.njit(cache=True, error_model="numpy")
def box_gap(a, b):  # type: ignore[no-untyped-def]
    """Give the distance between two axis-aligned boxes (6,), a bound on what is in them."""
    total = 0.0
    for i in range(3):
        gap = max(a[i] - b[i + 3], b[i] - a[i + 3], 0.0)
        total += gap * gap
    return math.sqrt(total)


@numba.njit(cache=True, error_model="numpy")
def mesh_separation(kind, half, turn, at, around, triangles, boxes, first, last, best):  # type: ignore[no-untyped-def]
    """Bound the gap between a shape and the triangles first ... last - 1, if it is below ``best``.

    The triangle with the nearest box goes first; most others are then farther by their boxes.
    """
    gaps, corners = np.empty(last - first), np.empty((3, 3))
    for k in range(first, last):
        gaps[k - first] = box_gap(around, boxes[k])
    front = gaps.argmin() + first
    for step in range(first - 1, last):
        k = front if step < first else step
        if gaps[k - first] < best and not (k == front and step >= first):
            for i in range(9):
                corners[i % 3, i // 3] = triangles[k, i]
            gap = separation(kind, half, turn, at, TRIANGLE, half, corners, triangles[k, :3])
            best = min(best, gap)
    return best
