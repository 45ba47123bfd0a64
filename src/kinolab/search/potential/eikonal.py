"""Navigation function: path length to a goal for a point among blocked cells.

It solves the eikonal equation |grad N| = 1/speed by fast sweeping. Every node's value derives from
smaller adjacent ones, so the goal is the only minimum.

Source: Barraquand, Latombe, IJRR 10(6), 1991.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import scipy
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.search.potential.fast_sweeping import arrival_times

Mask: TypeAlias = NDArray[np.bool_]

BLOCKED_SPEED = 1e-3  # speed in blocked cells, relative to open space
MIN_SPEED = 0.2  # the same next to an obstacle


@dataclass(frozen=True, eq=False)
class WorkspaceGrid:
    """Regular grid over some axes of the world.

    Attributes:
        axes: World axes: 0, 1 and 2 for x, y and z; two or three of them.
        origin: Lowest corner in [m], shape (axes,).
        size: Edge of a cell in [m].
        shape: Number of cells along each axis.
    """

    axes: tuple[int, ...]
    origin: Array
    size: float
    shape: tuple[int, ...]

    def centre(self, cell: tuple[int, ...]) -> Array:
        """Return the centre of a cell, shape (axes,)."""
        middle: Array = self.origin + self.size * (np.array(cell) + 0.5)
        return middle

    def cell_of(self, point: Array) -> tuple[int, ...]:
        """Return the cell that contains a world point (3,), or the nearest one."""
        place = (point[list(self.axes)] - self.origin) / self.size
        nearest = np.clip(np.floor(place).astype(int), 0, np.array(self.shape) - 1)
        return tuple(int(entry) for entry in nearest)


def cropped(grid: WorkspaceGrid, free: Mask, goal: Array) -> tuple[WorkspaceGrid, Mask]:
    """Crop a grid to all free cells and the goal (3,), with a margin of one cell."""
    found = np.argwhere(free)
    corner = np.rint((goal[list(grid.axes)] - grid.origin) / grid.size).astype(int)
    lowest, highest = (np.vstack([found, corner - k]) for k in (0, 1))
    first = np.maximum(lowest.min(axis=0) - 1, 0)
    last = np.minimum(highest.max(axis=0) + 2, grid.shape)
    part = free[tuple(slice(a, b) for a, b in zip(first, last, strict=True))]
    return WorkspaceGrid(grid.axes, grid.origin + grid.size * first, grid.size, part.shape), part


@dataclass(frozen=True, eq=False)
class NavigationFunction:
    """Path length to a goal, in [m] of open space, as a function of world points.

    Attributes:
        grid: Domain; points outside take the nearest value.
        values: At the corners of the cells, one more per axis than cells.
        goal: World point where it is 0, shape (3,).
        slowness: At the goal: 1 in open space, more where clearance is small.
    """

    grid: WorkspaceGrid
    values: Array
    goal: Array
    slowness: float

    def __call__(self, points: Array) -> tuple[Array, Array]:
        """Return values (n,) and gradients (n, 3) at points (n, 3)."""
        grid, axes = self.grid, list(self.grid.axes)
        place = (points[:, axes] - grid.origin) / grid.size
        top = np.array(grid.shape)
        inside = np.clip(place, 0.0, top)
        corner = np.minimum(inside.astype(int), top - 1)
        value, slope = self._interpolate(corner, inside - corner)
        gradient = np.zeros_like(points)
        gradient[:, axes] = slope / grid.size
        return self._near_goal(points, value, gradient)

    def _interpolate(self, corner: NDArray[Any], fraction: Array) -> tuple[Array, Array]:
        """Interpolate multilinearly in cells, corner and fraction (n, axes); slopes per cell."""
        count, dims = fraction.shape
        value, slope = np.zeros(count), np.zeros((count, dims))
        for bits in np.ndindex(*(2,) * dims):
            up = np.array(bits)
            factors = np.where(up, fraction, 1.0 - fraction)
            at = self.values[tuple((corner + up).T)]
            value += at * factors.prod(axis=1)
            for k in range(dims):
                others = np.delete(factors, k, axis=1).prod(axis=1)
                slope[:, k] += at * others * (1.0 if up[k] else -1.0)
        return value, slope

    def _near_goal(self, points: Array, value: Array, gradient: Array) -> tuple[Array, Array]:
        """Use the straight-line distance where it is shorter, within some cells of the goal."""
        away = np.zeros_like(points)
        axes = list(self.grid.axes)
        away[:, axes] = (points - self.goal)[:, axes]
        distance = np.linalg.norm(away, axis=1)
        straight = self.slowness * distance
        # cells around the goal in which paths are straight
        near = (distance < 2.0 * self.grid.size) & (straight < value)
        far = np.where(distance > 0, distance, 1.0)
        value = np.where(near, straight, value)
        return value, np.where(near[:, None], self.slowness * away / far[:, None], gradient)


def navigation_function(
    free: Mask, grid: WorkspaceGrid, goal: Array, clearance_cost_radius: float
) -> NavigationFunction:
    """Solve for the navigation function of a goal over free cells.

    Args:
        free: Mask of free cells, of the grid's shape.
        goal: World point at a corner of cells, shape (3,).
        clearance_cost_radius: Clearance in [m] below which path length is weighted, up to five
            times, to keep paths off obstacles; 0 for shortest paths.
    """
    speed = _speed(free, grid, clearance_cost_radius)
    corner = np.rint((goal[list(grid.axes)] - grid.origin) / grid.size)
    values = grid.size * arrival_times(speed, corner)
    return NavigationFunction(grid, values, goal, float(1.0 / speed[grid.cell_of(goal)]))


def _speed(free: Mask, grid: WorkspaceGrid, clearance_cost_radius: float) -> Array:
    if clearance_cost_radius <= 0:
        return np.where(free, 1.0, BLOCKED_SPEED)
    walled = np.pad(free, 1, constant_values=False)
    clearance = scipy.ndimage.distance_transform_edt(walled, sampling=grid.size)[
        (slice(1, -1),) * free.ndim
    ]
    return np.where(free, np.clip(clearance / clearance_cost_radius, MIN_SPEED, 1.0), BLOCKED_SPEED)
