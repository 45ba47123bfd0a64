"""Meshes of the floor: a slab with a grid, and rings on it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from kinolab.numerics.arrays import Array
from kinolab.show.film.models.surface_mesh import SurfaceMesh, weld

FLOOR = (0.925, 0.925, 0.905)
SIDE = (0.86, 0.86, 0.84)
MAX_LINES = 30  # along the longer side; larger worlds take a coarser grid
STEPS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)


def slab(low: Array, high: Array, thickness: float) -> tuple[SurfaceMesh, SurfaceMesh]:
    """The top of the floor between two corners, shape (2,), and the sides below it."""
    x = np.array([low[0], high[0], high[0], low[0]])
    y = np.array([low[1], low[1], high[1], high[1]])
    top = np.stack([x, y, np.zeros(4)], axis=1)
    i = np.arange(4)
    j = (i + 1) % 4
    sides = np.concatenate([np.stack([i, i + 4, j + 4], 1), np.stack([i, j + 4, j], 1)])
    both = np.concatenate([top, top - (0.0, 0.0, thickness)])
    return weld(top, [[0, 1, 2], [0, 2, 3]], FLOOR), weld(both, sides, SIDE)


def grid(low: Array, high: Array) -> Array:
    """Lines at whole multiples of the grid's step, shape (n, 2, 3), on z = 0."""
    step = grid_step(float(np.max(high - low)))
    along_y = [[(x, low[1], 0.0), (x, high[1], 0.0)] for x in _multiples(low[0], high[0], step)]
    along_x = [[(low[0], y, 0.0), (high[0], y, 0.0)] for y in _multiples(low[1], high[1], step)]
    return np.array(along_y + along_x, dtype=np.float64).reshape(-1, 2, 3)


def grid_step(length: float) -> float:
    """1 m if that gives 3 to 30 lines; else the step from 1, 2, 5, 10, ... that does."""
    if 3.0 <= length <= MAX_LINES:
        return 1.0
    return next((step for step in STEPS if length / step <= MAX_LINES), length)


def annulus(centre: ArrayLike, radii: tuple[float, float], color: ArrayLike) -> SurfaceMesh:
    """A flat ring on the ground about (x, y) between two radii in [m]; a disc if the first is 0."""
    n = 96
    angle = 2.0 * np.pi * np.arange(n) / n
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    flat = np.concatenate([radius * circle for radius in radii]) + np.asarray(centre)[:2]
    i = np.arange(n)
    j = (i + 1) % n
    faces = np.concatenate([np.stack([i, i + n, j + n], 1), np.stack([i, j + n, j], 1)])
    return weld(np.column_stack([flat, np.zeros(2 * n)]), faces, color)


def _multiples(low: float, high: float, step: float) -> Array:
    margin = 1e-9 * step
    return step * np.arange(np.ceil((low - margin) / step), np.floor((high + margin) / step) + 1)
