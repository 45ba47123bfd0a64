"""Points inside a mesh, as far as it is closed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array

ACROSS = 16  # points along each edge of the box around a mesh
OFF = np.array([0.41, 0.53, 0.44])  # of points in their cells: lines meet no edges and diagonals
CHUNK = 2000  # triangles that are looked at together


def interior_points(triangles: Array) -> Array:
    """Return points (m, 3) of a grid that are inside triangles (n, 3, 3).

    Those are inside from which a line along each of the axes leaves through an odd number of
    triangles. Behind a hole there are none.
    """
    corners = triangles.reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    grid = low + (high - low) * (np.arange(ACROSS)[:, None] + OFF) / ACROSS  # (ACROSS, 3)
    inside = np.ones((ACROSS,) * 3, dtype=bool)
    for axis in range(3):
        inside &= np.moveaxis(_odd(np.roll(triangles, -axis, axis=2), np.roll(grid, -axis, axis=1)),
                              (0, 1, 2), [(axis + k) % 3 for k in range(3)])  # fmt: skip
    x, y, z = np.nonzero(inside)
    return np.stack([grid[x, 0], grid[y, 1], grid[z, 2]], axis=1)


def _odd(triangles: Array, grid: Array) -> NDArray[np.bool_]:
    """Return where lines along the first axis cross an odd number of triangles (n, 3, 3) beyond.

    Args:
        grid: Coordinates of points along each axis, shape (m, 3).

    Returns:
        For each point of the grid, shape (m, m, m).
    """
    y, z = (part.reshape(-1) for part in np.meshgrid(grid[:, 1], grid[:, 2], indexing="ij"))
    crossed = np.zeros((len(grid) + 1, len(y)), dtype=int)  # between which points, by line
    for first in range(0, len(triangles), CHUNK):
        a, b, c = triangles[first : first + CHUNK].transpose(1, 2, 0)[..., None]  # each (3, n, 1)
        area = (b[1] - a[1]) * (c[2] - a[2]) - (c[1] - a[1]) * (b[2] - a[2])
        with np.errstate(divide="ignore", invalid="ignore"):  # those that are edge-on meet no line
            v = ((y - a[1]) * (c[2] - a[2]) - (c[1] - a[1]) * (z - a[2])) / area
            w = ((b[1] - a[1]) * (z - a[2]) - (y - a[1]) * (b[2] - a[2])) / area
            hit = (v >= 0.0) & (w >= 0.0) & (v + w <= 1.0)
        row, line = np.nonzero(hit)
        v, w = v[row, line], w[row, line]
        at = a[0, row, 0] + v * (b - a)[0, row, 0] + w * (c - a)[0, row, 0]
        np.add.at(crossed, (np.searchsorted(grid[:, 0], at), line), 1)
    beyond = crossed[::-1].cumsum(axis=0)[::-1][1:]
    odd: NDArray[np.bool_] = (beyond % 2 == 1).reshape(len(grid), len(grid), len(grid))
    return odd
