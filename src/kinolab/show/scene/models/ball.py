"""Balls whose octants differ in colour, so that rotation is visible."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array

Color: TypeAlias = tuple[float, float, float]
Pattern: TypeAlias = tuple[Array, NDArray[np.int64], Array]  # vertices, faces, their colours

PALE: Color = (0.99, 0.97, 0.93)


def ball(radius: float, color: Array, detail: int) -> Pattern:
    """A sphere whose octants alternate between a colour (3,) and a pale tint of it."""
    corners = _octahedron()
    for _ in range((1, 2, 3)[detail]):  # subdivisions of an octahedron
        corners = _quartered(corners)
    parity = np.prod(corners.mean(axis=1), axis=1) > 0.0
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    colors = np.where(parity[:, None], color, pale(color))
    return radius * corners.reshape(-1, 3), faces, colors


def pale(color: Array) -> Array:
    """A light tint of a colour, shape (3,)."""
    return np.asarray(0.2 * color + 0.8 * np.asarray(PALE), dtype=np.float64)


def _octahedron() -> Array:
    """The eight faces of the regular octahedron, seen counterclockwise, shape (8, 3, 3)."""
    x, y, z = np.eye(3)
    signs = [(i, j, k) for i in (1, -1) for j in (1, -1) for k in (1, -1)]
    faces = [[i * x, j * y, k * z][:: i * j * k] for i, j, k in signs]
    return np.array(faces)


def _quartered(corners: Array) -> Array:
    """Split every triangle on the unit sphere into four."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    sums = (a + b, b + c, c + a)
    ab, bc, ca = (both / np.linalg.norm(both, axis=1)[:, None] for both in sums)
    split = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(triangle, axis=1) for triangle in split])
