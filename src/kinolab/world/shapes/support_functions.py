"""Support functions of the convex shapes, compiled: how far a shape reaches in a direction.

Shapes are given as they lower themselves: a kind and half sizes in their own frame, which the
corners of a hull follow.
"""

from __future__ import annotations

import math

from kinolab.dynamics.language.shapes import ShapeKind
from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel

# The values of ``ShapeKind``; numba reads them as compile-time constants.
BOX, SPHERE, CYLINDER, CAPSULE, HULL = map(int, ShapeKind)


@kernel  # type: ignore[untyped-decorator]
def farthest_corner(half: Array, nx: float, ny: float, nz: float) -> int:
    """Return where in the numbers (3 + 3 corners,) of a hull its farthest corner along n begins."""
    best, found = -math.inf, 3
    for k in range(3, half.shape[0], 3):
        along = nx * half[k] + ny * half[k + 1] + nz * half[k + 2]
        if along > best:
            best, found = along, k
    return found


@kernel  # type: ignore[untyped-decorator]
def half_extent(kind: int, half: Array, nx: float, ny: float, nz: float) -> float:
    """Give the shape's reach from its centre along the unit vector n of its own frame, in [m].

    Args:
        kind: BOX, SPHERE, CYLINDER, CAPSULE or HULL.
        half: Half sizes in [m], shape (3,), and the corners of a hull.
        nx, ny, nz: Of the unit vector.
    """
    if kind == BOX:
        return abs(nx) * half[0] + abs(ny) * half[1] + abs(nz) * half[2]  # type: ignore[no-any-return]
    if kind == SPHERE:
        return half[0]  # type: ignore[no-any-return]
    if kind == CYLINDER:
        return half[0] * math.sqrt(nx * nx + ny * ny) + half[2] * abs(nz)  # type: ignore[no-any-return]
    if kind == HULL:
        k = farthest_corner(half, nx, ny, nz)
        return nx * half[k] + ny * half[k + 1] + nz * half[k + 2]  # type: ignore[no-any-return]
    return half[0] + half[2] * abs(nz)  # type: ignore[no-any-return]


@kernel  # type: ignore[untyped-decorator]
def core_radius(kind: int, half: Array) -> float:
    """Give the radius in [m] of half sizes (3,) that rounds a core: point, segment or solid."""
    return half[0] if kind in (SPHERE, CAPSULE) else 0.0


@kernel  # type: ignore[untyped-decorator]
def core_support(kind: int, half: Array, n: Array, point: Array) -> None:
    """Write the core's farthest point along n (3,), any length, own frame, to ``point`` (3,)."""
    point[0], point[1], point[2] = 0.0, 0.0, 0.0
    if kind == SPHERE:
        return
    if kind == HULL:
        k = farthest_corner(half, n[0], n[1], n[2])
        point[0], point[1], point[2] = half[k], half[k + 1], half[k + 2]
        return
    point[2] = math.copysign(half[2], n[2])
    if kind == BOX:
        point[0], point[1] = math.copysign(half[0], n[0]), math.copysign(half[1], n[1])
    if kind == CYLINDER:
        across = math.sqrt(n[0] * n[0] + n[1] * n[1])
        if across > 0.0:
            point[0], point[1] = half[0] * n[0] / across, half[0] * n[1] / across


@kernel  # type: ignore[untyped-decorator]
def move_into_core(kind: int, half: Array, point: Array) -> None:
    """Move a point (3,) of the shape's own frame to the nearest one of its core, or to a corner."""
    if kind == SPHERE:
        point[0], point[1], point[2] = 0.0, 0.0, 0.0
        return
    if kind == HULL:
        k = farthest_corner(half, point[0], point[1], point[2])
        point[0], point[1], point[2] = half[k], half[k + 1], half[k + 2]
        return
    point[2] = min(max(point[2], -half[2]), half[2])
    if kind == BOX:
        point[0] = min(max(point[0], -half[0]), half[0])
        point[1] = min(max(point[1], -half[1]), half[1])
        return
    radius = half[0] if kind == CYLINDER else 0.0
    across = math.sqrt(point[0] * point[0] + point[1] * point[1])
    if across > radius:
        point[0], point[1] = point[0] * radius / across, point[1] * radius / across


@kernel  # type: ignore[untyped-decorator]
def reach_along(kind: int, half: Array, axis: int) -> float:
    """Give the shape's reach from its centre along an axis of its own frame, in [m]."""
    if kind in (BOX, HULL):
        return half[axis]  # type: ignore[no-any-return]
    if kind == SPHERE or axis < 2:
        return half[0]  # type: ignore[no-any-return]
    return half[2] if kind == CYLINDER else half[2] + half[0]  # type: ignore[no-any-return]


@kernel  # type: ignore[untyped-decorator]
def dot(a: Array, b: Array) -> float:
    """Multiply two vectors (3,); a library call would take longer than the sum."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]  # type: ignore[no-any-return]
