"""Surfaces of shapes as triangles, each in the frame of a kind of shape."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

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
    angle = np.linspace(0.0, 2.0 * np.pi, corners + 1)[:-1]
    low = np.column_stack([np.cos(angle), np.sin(angle), np.full(corners, -half)])
    low[:, :2] *= radius
    rim = np.stack([low, low * [1.0, 1.0, -1.0]], axis=1)  # (corners, below and above, 3)
    centers = np.array([[0.0, 0.0, -half], [0.0, 0.0, half]])
    vertices = np.concatenate([centers[:1], rim[0], centers[1:], *rim[1:]])
    bottom, top = 0, 3  # the centres
    below = np.array([1, *range(4, 2 * corners + 2, 2)])
    above = np.array([2, *range(5, 2 * corners + 2, 2)])
    below_next, above_next = np.roll(below, -1), np.roll(above, -1)
    sectors = [
        (below, np.full(corners, bottom), below_next),
        (below, below_next, above),
        (above, below_next, above_next),
        (above, above_next, np.full(corners, top)),
    ]
    return vertices, np.array(sectors).transpose(2, 0, 1).reshape(-1, 3)


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
