"""Surfaces of shapes as triangles, each in the frame of a kind of shape."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.numerics.arrays import Array

Faces = NDArray[np.int64]

# Corners are numbered in binary: 4 for high x, 2 for high y, 1 for high z.
BOX_FACES = (
    *((1, 3, 0), (4, 1, 0), (0, 3, 2), (2, 4, 0), (1, 7, 3), (5, 1, 4)),
    *((5, 7, 1), (3, 7, 2), (6, 4, 2), (2, 7, 6), (6, 5, 4), (7, 5, 6)),
)


def box_surface(half: Array) -> tuple[Array, Faces]:
    """Return vertices (8, 3) and faces (12, 3) of a box with half edges (3,) in [m]."""
    corners = np.array(list(product((-1.0, 1.0), repeat=3)))
    return corners * half, np.array(BOX_FACES, dtype=np.int64)


def cylinder_surface(radius: float, half: float, corners: int) -> tuple[Array, Faces]:
    """Return vertices (2 corners + 2, 3) and faces (4 corners, 3) of a cylinder along z.

    Args:
        radius: In [m].
        half: Half its length, in [m].
        corners: Of the polygon that stands for the circle, and has its corners on it.
    """
    ends = [(0.0, -half), (radius, -half), (radius, half), (0.0, half)]
    return surface_of_revolution(ends, corners)


def surface_of_revolution(profile: ArrayLike, corners: int) -> tuple[Array, Faces]:
    """Turn a line about z, which has what it bounds on its left.

    Args:
        profile: Its points (radius, height), shape (n, 2); the first and the last may be on z.
        corners: Of the polygon that stands for a circle, and has its corners on it.

    Returns:
        Vertices (m, 3), ring after ring, and faces (k, 3), seen anticlockwise from outside: of each
        strip of ``corners`` quads the first halves, then the second ones, and of a fan its
        triangles.
    """
    line = np.asarray(profile, dtype=np.float64)
    angle = np.linspace(0.0, 2.0 * np.pi, corners + 1)[:-1]
    rings = (
        np.stack([np.cos(angle), np.sin(angle), np.ones(corners)], axis=1)
        * line[:, None, [0, 0, 1]]
    )
    here = np.arange(len(line) * corners).reshape(-1, corners)
    here[line[:, 0] == 0.0] = here[line[:, 0] == 0.0, :1]
    a, b = here, np.roll(here, -1, axis=1)
    halves = [np.stack([a[:-1], b[:-1], b[1:]], -1), np.stack([a[:-1], b[1:], a[1:]], -1)]
    faces = np.stack(halves, axis=1).reshape(-1, 3)
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    used, faces = np.unique(faces, return_inverse=True)
    return rings.reshape(-1, 3)[used], faces.reshape(-1, 3)


def ball_surface(radius: float) -> tuple[Array, Faces]:
    """Return vertices (642, 3) and faces (1280, 3) of a ball, an icosahedron divided thrice."""
    import trimesh  # late: it takes longer to import than a maze to be solved

    ball = trimesh.creation.icosphere(subdivisions=3)
    vertices = radius * np.asarray(ball.vertices, dtype=np.float64)
    return vertices, np.asarray(ball.faces, dtype=np.int64)


def capsule_surface(radius: float, half: float, corners: int) -> tuple[Array, Faces]:
    """Return vertices (n, 3) and faces (m, 3) of a capsule along z.

    Args:
        radius: In [m].
        half: Half its length without the caps, in [m].
        corners: Twice as many as of a circle around it.
    """
    import trimesh  # late, as above

    # Made at its usual size: corners of a tiny one would be taken for one and the same.
    capsule = trimesh.creation.capsule(2.0, 1.0, count=[corners // 2, corners // 2])
    vertices = np.asarray(capsule.vertices - capsule.bounds.mean(axis=0), dtype=np.float64)
    above = np.abs(vertices[:, 2]) - 1.0
    vertices[:, :2] *= radius
    vertices[:, 2] = np.copysign(above * radius + half, vertices[:, 2])
    return vertices, np.asarray(capsule.faces, dtype=np.int64)
