"""Meshes of the floor: a slab with a grid, and rings on it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from kinolab.numerics.arrays import Array
from kinolab.show.scene.models.setting import SceneColors
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, weld

BOARDS, BOARD = 12, 1.4  # number side by side; length, in widths of the floor
DASHES, KERBS = 41, 60  # along a road
STEPS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)


def floor_top(low: Array, high: Array, colors: SceneColors) -> SurfaceMesh:
    """The top of the floor between two corners, shape (2,)."""
    (a, b), (c, d) = low, high
    corners = [[a, b, 0.0], [c, b, 0.0], [c, d, 0.0], [a, d, 0.0]]
    return weld(corners, [[0, 1, 2], [0, 2, 3]], colors.floor)


def slab(
    low: Array, high: Array, thickness: float, colors: SceneColors
) -> tuple[SurfaceMesh, SurfaceMesh]:
    """The top of the floor between two corners, shape (2,), and the sides below it."""
    mesh = floor_top(low, high, colors)
    top = mesh.vertices
    i = np.arange(4)
    j = (i + 1) % 4
    sides = np.concatenate([np.stack([i, i + 4, j + 4], 1), np.stack([i, j + 4, j], 1)])
    both = np.concatenate([top, top - (0.0, 0.0, thickness)])
    return mesh, weld(both, sides, colors.side)


def marked_lines(low: Array, high: Array, colors: SceneColors) -> Array:
    """The thin lines on a floor between two corners, shape (n, 2, 3), on z = 0."""
    if colors.pattern == "grid":
        return grid(low, high)
    if colors.pattern == "boards":
        return boards(low, high)
    return np.zeros((0, 2, 3))


def boards(low: Array, high: Array) -> Array:
    """The joints of floor boards along the longer side, shape (n, 2, 3), on z = 0."""
    along = int(np.argmax(high - low))
    across, size = 1 - along, high - low
    places = low[across] + size[across] * np.arange(1, BOARDS) / BOARDS
    lines = np.zeros((len(places), 2, 3))
    lines[:, :, across] = places[:, None]
    lines[:, 0, along], lines[:, 1, along] = low[along], high[along]
    length = size[across] * BOARD
    ends = np.arange(low[along] + 0.5 * length, high[along], length)
    joints = np.zeros((len(ends) * BOARDS, 2, 3))
    edges = low[across] + size[across] * np.arange(BOARDS + 1) / BOARDS
    for k in range(BOARDS):  # boards side by side end at different places
        rows = joints[k::BOARDS]
        shift = length * ((k * 0.618) % 1.0)
        rows[:, :, along] = np.clip(ends + shift, low[along], high[along])[:, None]
        rows[:, :, across] = edges[k : k + 2]
    return np.concatenate([lines, joints])


def marked_areas(low: Array, high: Array, colors: SceneColors) -> Iterator[SurfaceMesh]:
    """What is painted on a floor between two corners (2,): the middle of a road, its kerbs."""
    if colors.pattern != "lane":
        return
    along = int(np.argmax(high - low))
    length, width = high[along] - low[along], high[1 - along] - low[1 - along]
    dash = length / DASHES
    middle = 0.5 * (low + high)[1 - along]
    for k in range(0, DASHES, 2):
        first = low[along] + k * dash
        yield _strip((first, first + dash), (middle, 0.012 * width), along, colors.lines)
    block = length / KERBS
    for side in (low, high):
        inward = 1.0 if side is low else -1.0
        place = side[1 - along] + inward * 0.02 * width
        for k in range(KERBS):
            first = low[along] + k * block
            color = (0.78, 0.22, 0.18) if k % 2 else colors.lines  # every second block of a kerb
            yield _strip((first, first + block), (place, 0.04 * width), along, color)


def _strip(
    ends: tuple[float, float], across: tuple[float, float], along: int, color: ArrayLike
) -> SurfaceMesh:
    """A rectangle on the ground between two places along an axis, by its middle and width."""
    middle, width = across
    sides = (middle - 0.5 * width, middle + 0.5 * width)
    points = np.zeros((4, 3))
    points[:, along] = [ends[0], ends[1], ends[1], ends[0]]
    points[:, 1 - along] = [sides[0], sides[0], sides[1], sides[1]]
    return weld(points, [[0, 1, 2], [0, 2, 3]], color)


def grid(low: Array, high: Array) -> Array:
    """Lines at whole multiples of the grid's step, shape (n, 2, 3), on z = 0."""
    step = grid_step(float(np.max(high - low)))
    along_y = [[(x, low[1], 0.0), (x, high[1], 0.0)] for x in _multiples(low[0], high[0], step)]
    along_x = [[(low[0], y, 0.0), (high[0], y, 0.0)] for y in _multiples(low[1], high[1], step)]
    return np.array(along_y + along_x, dtype=np.float64).reshape(-1, 2, 3)


def grid_step(length: float) -> float:
    """1 m if that gives 3 to 30 lines; else the step from 1, 2, 5, 10, ... that does."""
    if 3.0 <= length <= 30:
        return 1.0
    return next((step for step in STEPS if length / step <= 30), length)


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
