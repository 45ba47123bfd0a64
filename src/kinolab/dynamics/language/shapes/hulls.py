"""Polytopes around convex bodies, of which only the support function is known."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array

SIDES = 32  # of a polygon that stands for a circle around which it is drawn
STANDS_OUT = 1.0 / math.cos(math.pi / SIDES) - 1.0  # its corners, of the radius: 0.5 %

ROUNDING = 1e-9  # of a size


def hull_around(support: Callable[[Array], Array]) -> Array:
    """Return the corners (n, 3) of a polytope that holds a convex body, all of it.

    It is the intersection of half spaces that touch the body, so no sampling can cut anything off.
    Where a corner stands out farther than that of a polygon of 32 sides around a circle as large as
    the body, another half space cuts it off: about 700 of them hold a ball.

    Args:
        support: Gives the body's farthest points (m, 3) along unit vectors (m, 3).

    Raises:
        ValueError: If the body is flat or does not hold its centre, or is not convex.
    """
    from scipy.spatial import HalfspaceIntersection  # late: few shapes ask

    steps = np.array([step for step in product((-1.0, 0.0, 1.0), repeat=3) if any(step)])
    normals = steps / np.linalg.norm(steps, axis=1, keepdims=True)
    while True:
        touched = support(normals)
        offsets = np.einsum("ij,ij->i", normals, touched)
        size = float(np.linalg.norm(touched, axis=1).max())
        if not offsets.min() > ROUNDING * size:
            raise ValueError("it is flat, or does not hold its centre")
        if (normals @ touched.T > offsets[:, None] + ROUNDING * size).any():
            raise ValueError("no convex solid has such farthest points")
        held = HalfspaceIntersection(np.column_stack([normals, -offsets]), np.zeros(3))
        corners: Array = held.intersections
        between = np.array([normals[facets].mean(axis=0) for facets in held.dual_facets])
        between /= np.linalg.norm(between, axis=1, keepdims=True)
        farthest = np.einsum("ij,ij->i", between, support(between))
        out = np.einsum("ij,ij->i", between, corners) - farthest > STANDS_OUT * size
        if not out.any():
            return corners
        normals = np.concatenate([normals, between[out]])


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
