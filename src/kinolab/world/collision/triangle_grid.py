"""A grid over the triangles of the meshes, seen from above: the few that matter at a place.

Each cell of the x-y plane lists the triangles whose shadow may touch it. One look at a cell
answers whether a point is inside a solid (which faces does a vertical line through it cross?) and
whether a box is near any triangle.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.world.mesh_components import components
from kinolab.world.obstacle import Obstacle

Integers = NDArray[np.int64]
MAX_CELLS_PER_SIDE = 1024
MAX_ENTRIES_PER_TRIANGLE = 16  # keeps a mesh of many large triangles from filling the memory


class MeshGrid(NamedTuple):
    """All meshes of a world in flat arrays, for compiled code."""

    triangles: Array  # (m, 9): three corners, in [m]
    boxes: Array  # (m, 6): lowest and highest x, y, z of each triangle
    part: Integers  # (m,) the connected part of each triangle, numbered over all meshes
    volume: Array  # (parts,) signed volume, 0 where only the surface collides
    frame: Array  # (meshes, 3): x, y of the grid's corner and the width of a cell
    extent: Integers  # (meshes, 3): cells in x, cells in y, index of the first cell
    start: Integers  # (cells + 1,) where the list of each cell starts in ``entries``
    entries: Integers  # triangles, cell by cell, in ascending order


def mesh_grid(obstacles: Sequence[Obstacle]) -> MeshGrid:
    """Index the triangles of meshes; an empty sequence gives empty arrays.

    What was made of a mesh is kept as long as the mesh is: nobody may write to it.
    """
    grids = [_kept(obstacle) for obstacle in obstacles]
    if not grids:
        return MeshGrid(*_EMPTY)
    if len(grids) == 1:
        return _ended(grids[0])
    counts = np.cumsum([[0, 0, 0, 0]] + [_counts(grid) for grid in grids], axis=0)
    shifted = [_shift(g, *count) for g, count in zip(grids, counts, strict=False)]
    joined = [np.concatenate(column) for column in zip(*shifted, strict=True)]
    return _ended(MeshGrid(*joined))


def _ended(grid: MeshGrid) -> MeshGrid:
    return grid._replace(start=np.append(grid.start, len(grid.entries)))


_known: WeakKeyDictionary[Obstacle, MeshGrid] = WeakKeyDictionary()


def _kept(obstacle: Obstacle) -> MeshGrid:
    grid = _known.get(obstacle)
    if grid is None:
        grid = _known[obstacle] = _single(obstacle)
    return grid


_EMPTY = (
    *(np.zeros((0, 9)), np.zeros((0, 6)), np.zeros(0, np.int64), np.zeros(0)),
    *(np.zeros((0, 3)), np.zeros((0, 3), np.int64), np.zeros(1, np.int64), np.zeros(0, np.int64)),
)


def _counts(grid: MeshGrid) -> list[int]:
    return [len(grid.triangles), len(grid.volume), len(grid.start), len(grid.entries)]


def _shift(grid: MeshGrid, triangles: int, parts: int, cells: int, entries: int) -> MeshGrid:
    return grid._replace(
        part=grid.part + parts,
        extent=grid.extent + np.array([0, 0, cells]),
        start=grid.start + entries,
        entries=grid.entries + triangles,
    )


def _single(obstacle: Obstacle) -> MeshGrid:
    """Index one mesh; ``start`` lacks its last entry, which the next mesh gives."""
    parts = obstacle.parts or components(obstacle.vertices, obstacle.faces)
    order = np.argsort(parts.label, kind="stable")  # a cell then lists each part in one run
    corners = obstacle.vertices[obstacle.faces[order]]
    boxes = np.concatenate([corners.min(axis=1), corners.max(axis=1)], axis=1)
    frame, first, last, nx, ny = _cells(boxes)
    start, entries = _lists(first, last, nx, ny)
    volume = parts.volume if obstacle.solid else np.zeros_like(parts.volume)
    extent = np.array([[nx, ny, 0]])
    triangles = np.ascontiguousarray(corners.reshape(-1, 9))
    return MeshGrid(
        triangles, boxes, parts.label[order], volume, frame[None], extent, start, entries
    )


def _cells(boxes: Array) -> tuple[Array, Integers, Integers, int, int]:
    """Choose the finest grid that stays within the memory allowed."""
    low, high = boxes[:, :2].min(axis=0), boxes[:, 3:5].max(axis=0)
    side = min(MAX_CELLS_PER_SIDE, int(np.ceil(2.0 * np.sqrt(len(boxes)))))
    while True:
        width = max(float((high - low).max()) / side, np.finfo(float).tiny)
        nx, ny = (int(n) for n in np.floor((high - low) / width) + 1)
        limit = np.array([nx, ny]) - 1
        first = np.clip(np.floor((boxes[:, :2] - low) / width), 0, limit).astype(np.int64)
        last = np.clip(np.floor((boxes[:, 3:5] - low) / width), 0, limit).astype(np.int64)
        total = int((last - first + 1).prod(axis=1).sum())
        if side == 1 or total <= MAX_ENTRIES_PER_TRIANGLE * len(boxes) + 1000:
            return np.array([*low, width]), first, last, nx, ny
        side //= 2


def _lists(first: Integers, last: Integers, nx: int, ny: int) -> tuple[Integers, Integers]:
    """List the triangles of each cell; ``first`` and ``last`` are cells (m, 2), inclusive."""
    span = last - first + 1
    count = span.prod(axis=1)
    triangle = np.repeat(np.arange(len(first)), count)
    place = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    column = first[triangle, 0] + place % span[triangle, 0]
    row = first[triangle, 1] + place // span[triangle, 0]
    cell = row * nx + column
    order = np.argsort(cell, kind="stable")
    start = np.searchsorted(cell[order], np.arange(nx * ny))
    return start.astype(np.int64), triangle[order]
