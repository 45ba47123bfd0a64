"""Polytopes around convex bodies, of which only the support function is known."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array

SIDES = 32  # of a polygon that stands for a circle around which it is drawn
STANDS_OUT = 1.0 / math.cos(math.pi / SIDES) - 1.0  # its corners, of the radius: 0.5 %

ROUNDING = 1e-9  # of a size

Support: TypeAlias = Callable[[Array], Array]


def hull_around(support: Support, symmetric: str = "") -> Array:
    """Return the corners (n, 3) of a polytope that holds a convex body, all of it.

    It is the intersection of half spaces that touch the body, so no sampling can cut anything off.
    Where a corner stands out farther than that of a polygon of 32 sides around a circle as large as
    the body, another half space cuts it off: about 700 of them hold a ball.

    Args:
        support: Gives the body's farthest points (m, 3) along unit vectors (m, 3).
        symmetric: Axes about which the body is said to be round: "", "z" or "xyz".

    Raises:
        ValueError: If there is no such body; it says why.
    """
    from scipy.spatial import HalfspaceIntersection  # late: few shapes ask

    steps = np.array([step for step in product((-1.0, 0.0, 1.0), repeat=3) if any(step)])
    normals = steps / np.linalg.norm(steps, axis=1, keepdims=True)
    while True:
        touched = _farthest(support, normals)
        offsets = np.einsum("ij,ij->i", normals, touched)
        size = float(np.linalg.norm(touched, axis=1).max())
        _require_convex(normals, touched, offsets, ROUNDING * size)
        held = HalfspaceIntersection(np.column_stack([normals, -offsets]), np.zeros(3))
        corners: Array = held.intersections
        between = np.array([normals[facets].mean(axis=0) for facets in held.dual_facets])
        between /= np.linalg.norm(between, axis=1, keepdims=True)
        farthest = np.einsum("ij,ij->i", between, _farthest(support, between))
        out = np.einsum("ij,ij->i", between, corners) - farthest > STANDS_OUT * size
        if not out.any():
            require_round(support, normals, symmetric, ROUNDING * size)
            return corners
        normals = np.concatenate([normals, between[out]])


def require_round(support: Support, normals: Array, symmetric: str, slack: float) -> None:
    """Require that a body's reach along unit vectors (n, 3) is the same about some axes.

    Args:
        support: As in ``hull_around``.
        normals: The unit vectors.
        symmetric: "", "z" or "xyz".
        slack: By how much lengths may differ, in [m].

    Raises:
        ValueError: If it is not.
    """
    if symmetric not in ("", "z", "xyz"):
        raise ValueError(f'symmetric is {symmetric!r}, and can be "", "z" or "xyz"')
    if not symmetric:
        return
    turned = np.zeros_like(normals)  # about z into the plane of x and z, or to the pole
    turned[:, 0] = np.hypot(normals[:, 0], normals[:, 1])
    turned[:, 2] = normals[:, 2]
    if symmetric == "xyz":
        turned[:] = (0.0, 0.0, 1.0)
    reach, other = (np.einsum("ij,ij->i", n, _farthest(support, n)) for n in (normals, turned))
    k = int(np.abs(reach - other).argmax())
    if abs(reach[k] - other[k]) > slack:
        what = f"it reaches {reach[k]:g} m along n = {_shown(normals[k])}"
        what += f" and {other[k]:g} m along {_shown(turned[k])}"
        raise ValueError(f'symmetric is "{symmetric}", but {what}')


def _farthest(support: Support, normals: Array) -> Array:
    """Return the farthest points along unit vectors, (n, 3) both."""
    try:
        found = np.asarray(support(normals.copy()), dtype=float)
    except Exception as error:
        raise ValueError(f"support(…) failed ({type(error).__name__}: {error})") from error
    if found.shape != normals.shape:
        raise ValueError(f"support(…) returned the shape {found.shape}, expected {normals.shape}")
    if not np.isfinite(found).all():
        raise ValueError(f"support(…) returned {found[~np.isfinite(found)][0]}")
    return found


def _require_convex(normals: Array, touched: Array, offsets: Array, slack: float) -> None:
    """Require that points are the farthest ones of a solid about the origin.

    Args:
        normals: Unit vectors n, opposite ones among them.
        touched: The points p.
        offsets: n . p.
        slack: By how much lengths may differ, in [m].

    Raises:
        ValueError: If they are not.
    """
    k = int(offsets.argmin())
    if not offsets[k] > slack:
        flat = abs(offsets[k]) <= slack and (np.abs(touched @ normals[k]) <= slack).all()
        n, none = _shown(normals[k]), "so p is not the farthest point, or the centre is outside"
        raise ValueError(
            f"it is flat along n = {n}" if flat else f"n.p is {offsets[k]:g} m along {n}, {none}"
        )
    beyond = normals @ touched.T - offsets[:, None]
    i, j = np.unravel_index(int(beyond.argmax()), beyond.shape)
    if beyond[i, j] > slack:
        n, other = _shown(normals[i]), _shown(normals[j])
        what = f"along n = {n} its point has n.p = {offsets[i]:g} m"
        raise ValueError(f"{what}, and that of {other} lies {beyond[i, j]:g} m farther along n")


def _shown(vector: Array) -> str:
    return f"({', '.join(f'{entry:.3g}' for entry in vector)})"


def hull_surface(corners: Array) -> tuple[Array, NDArray[np.int64], Array]:
    """Return the surface of the convex hull of points (n, 3).

    Returns:
        Vertices (m, 3); faces (k, 3), seen anticlockwise from outside; and their planes (k, 4),
        outward unit normals and what is added to a point's height along them to be 0 there.
    """
    from scipy.spatial import ConvexHull

    hull = ConvexHull(corners)
    rows, faces = np.unique(hull.simplices, return_inverse=True)
    vertices, faces = corners[rows], faces.reshape(-1, 3).astype(np.int64)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return vertices, faces, hull.equations


def grown_hull(corners: Array, by: float) -> Array:
    """Return the corners of a hull (n, 3) whose planes are moved outward by a length."""
    from scipy.spatial import HalfspaceIntersection

    planes = np.unique(hull_surface(corners)[2], axis=0) - [0.0, 0.0, 0.0, by]
    found: Array = HalfspaceIntersection(planes, corners.mean(axis=0)).intersections
    return found
