"""A grid over the triangles of the meshes, seen from above: the few that matter at a place.

Each cell of the x-y plane lists the triangles whose shadow may touch it. One look at a cell
answers whether a point is inside a solid (which faces does a vertical line through it cross?) and
whether a box is near any triangle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.world.meshes.mesh_components import components
from kinolab.world.obstacles.kept_together import kept_together
from kinolab.world.obstacles.obstacle import Obstacle


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
    # (m,) [m] by which the things are larger all round than their triangles: balls around points
    ball: Array


def mesh_grid(obstacles: Sequence[Obstacle]) -> MeshGrid:
    """Index the triangles of meshes; an empty sequence gives empty arrays.

    What was made of a mesh is kept as long as the mesh is: nobody may write to it.
    """
    grids = [_kept((obstacle,)) for obstacle in obstacles]
    if not grids:
        return MeshGrid(*_EMPTY)
    if len(grids) == 1:
        return _ended(grids[0])
    sizes = [[len(g.triangles), len(g.volume), len(g.start), len(g.entries)] for g in grids]
    before = np.cumsum([[0, 0, 0, 0], *sizes], axis=0)
    shifted = [
        grid._replace(
            part=grid.part + parts,
            extent=grid.extent + np.array([0, 0, cells]),
            start=grid.start + entries,
            entries=grid.entries + triangles,
        )
        for grid, (triangles, parts, cells, entries) in zip(grids, before, strict=False)
    ]
    joined = [np.concatenate(column) for column in zip(*shifted, strict=True)]
    return _ended(MeshGrid(*joined))


def _ended(grid: MeshGrid) -> MeshGrid:
    return grid._replace(start=np.append(grid.start, len(grid.entries)))


_EMPTY = (
    *(np.zeros((0, 9)), np.zeros((0, 6)), np.zeros(0, np.int64), np.zeros(0)),
    *(np.zeros((0, 3)), np.zeros((0, 3), np.int64), np.zeros(1, np.int64), np.zeros(0, np.int64)),
    np.zeros(0),
)


def _single(obstacle: Obstacle) -> MeshGrid:
    """Index one mesh; ``start`` lacks its last entry, which the next mesh gives."""
    parts = obstacle.parts or components(obstacle.vertices, obstacle.faces)
    order = np.argsort(parts.label, kind="stable")  # a cell then lists each part in one run
    corners = obstacle.vertices[obstacle.faces[order]]
    ball = obstacle.ball
    boxes = np.concatenate([corners.min(axis=1) - ball, corners.max(axis=1) + ball], axis=1)
    frame, first, last, nx, ny = _cells(boxes, 2.0 * ball)
    start, entries = _lists(first, last, nx, ny)
    volume = parts.volume if obstacle.solid else np.zeros_like(parts.volume)
    extent = np.array([[nx, ny, 0]])
    triangles = np.ascontiguousarray(corners.reshape(-1, 9))
    around, balls = frame[None], np.full(len(boxes), ball)
    return MeshGrid(
        triangles, boxes, parts.label[order], volume, around, extent, start, entries, balls
    )


_kept = kept_together(lambda one: _single(*one))


def _cells(boxes: Array, finest: float) -> tuple[Array, Integers, Integers, int, int]:
    """Choose the finest grid that stays within the memory allowed, and above a width in [m]."""
    low, high = boxes[:, :2].min(axis=0), boxes[:, 3:5].max(axis=0)
    side = min(1024, int(np.ceil(2.0 * np.sqrt(len(boxes)))))
    while True:
        width = max(float((high - low).max()) / side, finest, np.finfo(float).tiny)
        nx, ny = (int(n) for n in np.floor((high - low) / width) + 1)
        limit = np.array([nx, ny]) - 1
        first = np.clip(np.floor((boxes[:, :2] - low) / width), 0, limit).astype(np.int64)
        last = np.clip(np.floor((boxes[:, 3:5] - low) / width), 0, limit).astype(np.int64)
        total = int((last - first + 1).prod(axis=1).sum())
        # keeps a mesh of many large triangles from filling the memory
        if side == 1 or total <= 16 * len(boxes) + 1000:
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


@kernel
def overlap(a, b):  # type: ignore[no-untyped-def]
    """Say whether two boxes (6,) share a point."""
    return (
        a[0] <= b[3]
        and b[0] <= a[3]
        and a[1] <= b[4]
        and b[1] <= a[4]
        and a[2] <= b[5]
        and b[2] <= a[5]
    )


@kernel
def cell_of(offset, count):  # type: ignore[no-untyped-def]
    """Give the cell at an offset counted in cells, the first or last one beyond the grid."""
    return int(min(max(offset, 0.0), count - 1.0))


@kernel
def near_surface(box, mesh, grid):  # type: ignore[no-untyped-def]
    """Say whether a box (6,) may touch a triangle of a mesh; True after looking at too many."""
    boxes, frame, extent = grid.boxes, grid.frame, grid.extent
    start, entries = grid.start, grid.entries
    x, y, width = frame[mesh, 0], frame[mesh, 1], frame[mesh, 2]
    nx, ny, cell = extent[mesh, 0], extent[mesh, 1], extent[mesh, 2]
    left, right = cell_of((box[0] - x) / width, nx), cell_of((box[3] - x) / width, nx)
    front, back = cell_of((box[1] - y) / width, ny), cell_of((box[4] - y) / width, ny)
    checks = 0
    for row in range(front, back + 1):
        for here in range(cell + row * nx + left, cell + row * nx + right + 1):
            for k in range(start[here], start[here + 1]):
                if overlap(box, boxes[entries[k]]):
                    return True
            checks += start[here + 1] - start[here] + 1
            if checks > 256:  # triangles, before FCL's tree is the better judge
                return True
    return False


@kernel
def left_of(x, y, ax, ay, bx, by):  # type: ignore[no-untyped-def]
    """Say whether (x, y) lies left of the edge, given its ends in any order, at its height.

    The lower end always comes first in the arithmetic, so that both triangles at an edge get the
    same answer to the last bit, and a line through an edge or a corner is counted once.

    Args:
        x, y: The point in [m].
        ax, ay, bx, by: The ends in [m].
    """
    if ay > by or (ay == by and ax > bx):
        ax, ay, bx, by = bx, by, ax, ay
    return (bx - ax) * (y - ay) - (x - ax) * (by - ay) > 0.0


@kernel
def shadow(x, y, t):  # type: ignore[no-untyped-def]
    """Say whether (x, y) is in the triangle (9,) seen from above: 1 or -1 by its turn, else 0."""
    crossings, winding = 0, 0
    for k in range(3):
        ax, ay = t[3 * k], t[3 * k + 1]
        bx, by = t[3 * ((k + 1) % 3)], t[3 * ((k + 1) % 3) + 1]
        if (ay > y) != (by > y) and left_of(x, y, ax, ay, bx, by):
            crossings += 1
            winding += 1 if by > ay else -1
    return winding if crossings == 1 else 0


@kernel
def height(x, y, t):  # type: ignore[no-untyped-def]
    """Give the z of a triangle's plane at (x, y), kept between its lowest and highest corner.

    A triangle that is steep to the last bit has an ill-determined height, but then (x, y) is
    within rounding of the triangle itself.
    """
    ux, uy, uz = t[3] - t[0], t[4] - t[1], t[5] - t[2]
    vx, vy, vz = t[6] - t[0], t[7] - t[1], t[8] - t[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    z = t[2] if nz == 0.0 else t[2] - (nx * (x - t[0]) + ny * (y - t[1])) / nz
    return min(max(z, min(t[2], t[5], t[8])), max(t[2], t[5], t[8]))


@kernel
def inside(p, mesh, grid):  # type: ignore[no-untyped-def]
    """Say whether a point (3,) lies in the solid of a mesh.

    Counts the faces above the point by the way they look, part by part. The smallest closed part
    around the point decides: a pillar in a room is solid, a room in a rock is not.
    """
    triangles, part, volume = grid.triangles, grid.part, grid.volume
    frame, extent, start, entries = grid.frame, grid.extent, grid.start, grid.entries
    nx, ny = extent[mesh, 0], extent[mesh, 1]
    column, row = (p[0] - frame[mesh, 0]) / frame[mesh, 2], (p[1] - frame[mesh, 1]) / frame[mesh, 2]
    if not (0.0 <= column <= nx and 0.0 <= row <= ny):
        return False
    here = extent[mesh, 2] + cell_of(row, ny) * nx + cell_of(column, nx)
    smallest, winding, current = math.inf, 0, -1
    verdict = False
    for k in range(start[here], start[here + 1] + 1):
        last = k == start[here + 1]
        if last or part[entries[k]] != current:
            if winding != 0 and abs(volume[current]) < smallest:
                smallest, verdict = abs(volume[current]), volume[current] > 0.0
            if last:
                break
            current, winding = part[entries[k]], 0
        if volume[current] != 0.0:
            turn = shadow(p[0], p[1], triangles[entries[k]])
            if turn != 0 and height(p[0], p[1], triangles[entries[k]]) > p[2]:
                winding += turn
    return verdict
