"""A grid of lower bounds on the distance to the obstacles of a world.

A cell counts as taken where a triangle or a primitive reaches into it, or a solid fills it. The
centre of a free cell is at least as far from every obstacle as from the nearest taken centre, less
half a cell's diagonal: that is what the grid keeps, so that no answer is ever too large.

Source of the transform: Felzenszwalb, Huttenlocher, Distance transforms of sampled functions,
Theory of Computing 8, 2012.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import allocating_kernel, kernel
from kinolab.numerics.struct import Record
from kinolab.world.distances.gjk import Convex, separation
from kinolab.world.distances.placed_shapes import obstacle_arrays
from kinolab.world.distances.triangle_grid import MeshGrid, inside, mesh_grid
from kinolab.world.obstacles.kept_together import kept_together
from kinolab.world.obstacles.obstacle import Obstacle
from kinolab.world.obstacles.redundant_obstacles import without_redundant
from kinolab.world.shapes.support_functions import SPHERE

SLACK, SURE = 1e-6, 1e-8  # of a cell, and in [m], to which separations are known
TRANSFORM_REACH = 0.5 * math.sqrt(3.0)  # half the diagonal of a cell of edge 1

Taken = NDArray[np.uint8]


class DistanceField(NamedTuple):
    """Lower bounds on distances, for compiled code; without any cell in an empty world."""

    low: Array  # (3,) lowest corner in [m]
    width: float  # edge of a cell in [m]
    # (nz, ny, nx) of the cells' centres in [m]: what moves over a floor stays within few layers
    distance: NDArray[np.float32]


def distance_field(
    obstacles: Sequence[Obstacle], finest: float = 0.0, memory: int = 256 * 2**20
) -> DistanceField:
    """Build the grid of some obstacles, as fine as memory and time allow.

    Args:
        obstacles: Of a world; the ground is not one of them.
        finest: Edge of a cell in [m] below which nothing is gained.
        memory: In [bytes], at most.
    """
    if not obstacles:
        return DistanceField(np.zeros(3), 1.0, np.zeros((0, 0, 0), np.float32))
    boxes = obstacle_arrays(obstacles).box
    low = boxes[:, :3].min(axis=0)
    span = boxes[:, 3:].max(axis=0) - low
    # cells that are built in well under a second
    cells = max(1, min(5_000_000, memory // np.dtype(np.float32).itemsize))
    largest = float(span.max())
    width = max(finest, largest * 1e-4, float(np.finfo(float).tiny))
    while np.maximum(np.ceil(span / width), 1).prod() > cells:
        width *= 1.05
    shape = tuple(int(n) for n in np.maximum(np.ceil(span / width), 1))
    # A little room, so that what lies in the highest plane lies in the grid.
    low = low - 0.5 * (np.array(shape) * width - span)
    taken = np.zeros(shape, np.uint8)
    meshes = [obstacle for obstacle in obstacles if obstacle.primitive is None]
    grid = mesh_grid(meshes)
    if meshes:
        mark_triangles(grid.triangles, grid.boxes, low, width, taken)
        _fill_solids(grid, low, width, taken)
    left = {id(obstacle) for obstacle in without_redundant(obstacles)}
    placed = obstacle_arrays(obstacles)
    rows = []
    for k, obstacle in enumerate(obstacles):
        if obstacle.primitive is not None and id(obstacle) in left:
            left.remove(id(obstacle))  # one thing may be there more than once
            rows.append(k)
    mark_shapes(np.array(rows, np.int64), *placed[:5], low, width, taken)
    return DistanceField(low, width, _distances(taken, width))


@kept_together
def digest(obstacles: Sequence[Obstacle]) -> str:
    """Return what tells obstacles apart whose grids differ."""
    found = hashlib.sha256()
    for numbers in obstacle_arrays(obstacles)[:6]:  # blocks follow from these
        found.update(np.ascontiguousarray(numbers).tobytes())
    for k, obstacle in enumerate(obstacles):
        if obstacle.primitive is None:
            found.update(repr((k, obstacle.solid, len(obstacle.vertices))).encode())
            found.update(repr(obstacle.ball).encode() if obstacle.ball else b"")
            found.update(np.ascontiguousarray(obstacle.vertices).tobytes())
            found.update(np.ascontiguousarray(obstacle.faces).tobytes())
    return found.hexdigest()


def _fill_solids(grid: MeshGrid, low: Array, width: float, taken: Taken) -> None:
    """Mark the cells inside of solids: no surface separates the free cells of one component."""
    if not grid.volume.any():
        return
    label, count = scipy.ndimage.label(taken == 0)
    cell = np.zeros(count + 1, np.int64)  # one of every label
    cell[label.ravel()] = np.arange(label.size)
    cells = np.stack(np.unravel_index(cell[1:], label.shape), axis=1)
    centers, arrays = low + (cells + 0.5) * width, Record(grid)
    full = np.zeros(count + 1, np.uint8)
    for k, center in enumerate(centers, start=1):
        full[k] = any(inside(center, mesh, arrays) for mesh in range(len(grid.frame)))
    if full.any():
        taken |= full[label]


def _distances(taken: Taken, width: float) -> NDArray[np.float32]:
    squares = np.where(taken, np.float32(0.0), np.float32(np.inf))
    for axis in range(3):
        transform(squares if axis == 2 else np.moveaxis(squares, axis, 2))
    np.sqrt(squares, out=squares)
    squares -= TRANSFORM_REACH
    # share by which bounds are lowered, for rounding to single precision
    squares *= width * (1.0 - 1e-6)
    np.maximum(squares, np.float32(0.0), out=squares)
    return np.ascontiguousarray(squares.T)


@allocating_kernel
def transform(squares):  # type: ignore[no-untyped-def]
    """Lower every value along the last axis to the least of value + squared distance in cells."""
    nx, ny, n = squares.shape
    line, at, border = np.empty(n), np.empty(n, np.int64), np.empty(n + 1)
    for i in range(nx):
        for j in range(ny):
            top = -1
            for q in range(n):
                line[q] = squares[i, j, q]
                if not math.isfinite(line[q]):
                    continue
                cut = -math.inf
                while top >= 0:
                    p = at[top]
                    cut = (line[q] + q * q - line[p] - p * p) / (2.0 * (q - p))
                    if cut > border[top]:
                        break
                    top -= 1
                    cut = -math.inf
                top += 1
                at[top], border[top], border[top + 1] = q, cut, math.inf
            if top < 0:
                continue
            k = 0
            for q in range(n):
                while border[k + 1] < q:
                    k += 1
                squares[i, j, q] = line[at[k]] + (q - at[k]) ** 2


@kernel
def cell_range(low, width, count, first, last):  # type: ignore[no-untyped-def]
    """Return the cells along one axis that an interval reaches, one past the last of them.

    Args:
        low, width: Of the grid along the axis, in [m].
        count: Its cells.
        first, last: The interval in [m].
    """
    begin = math.floor((first - low) / width - 1e-6)
    end = math.floor((last - low) / width + 1e-6) + 1
    return min(max(begin, 0), count - 1), min(max(end, 1), count)


@kernel
def copy_block(given, block):  # type: ignore[no-untyped-def]
    """Copy a block of cells; numba's own copy compiles the text of its error, for two seconds.

    Args:
        given: First cells and those one past the last, shape (3, 2).
        block: The copy, shape (3, 2); written.
    """
    for i in range(3):
        block[i, 0], block[i, 1] = given[i, 0], given[i, 1]


@allocating_kernel
def mark_shapes(rows, kind, half, turn, at, box, low, width, taken):  # type: ignore[no-untyped-def]
    """Mark the cells near placed shapes, as ``mark_shape`` does near one.

    Args:
        rows: Which of the shapes, shape (m,).
        kind, half: Kinds (n,) and half sizes (n, 3) in [m].
        turn, at: Rotations (n, 3, 3) and centres (n, 3) in [m].
        box: Lowest and highest x, y, z in [m], shape (n, 6).
        low, width: The grid's lowest corner, shape (3,), and a cell's width, in [m].
        taken: Whether cells are marked, shape (nx, ny, nz); written.
    """
    for k in rows:
        shape = Convex(kind[k], half[k], turn[k], at[k])
        mark_shape(shape, box[k, :3], box[k, 3:], low, width, taken)


@allocating_kernel
def mark_shape(shape, first, last, low, width, taken):  # type: ignore[no-untyped-def]
    """Mark the cells whose centre is within half a diagonal of a convex shape.

    Blocks of cells are halved where the shape's border may run through them. None of a block is
    marked if its middle is too far away by more than its radius, all of it if its corners are near:
    what is within some distance of a convex shape is convex. What is marked is not asked again.

    Args:
        shape: ``Convex``.
        first, last: Its lowest and highest x, y, z in [m], shape (3,).
        low, width: The grid's lowest corner, shape (3,), and a cell's width, in [m].
        taken: Whether cells are marked, shape (nx, ny, nz); written.
    """
    reach = TRANSFORM_REACH * width
    slack = SLACK * width + SURE  # nearer than that to a decision each cell is asked itself
    center = np.zeros(3)
    point = Convex(np.int64(SPHERE), np.zeros(3), np.eye(3), center)  # of a block or a cell
    # blocks at once: 3 x 23 halvings of as many cells as there are, and one more each
    stack = np.zeros((128, 3, 2), np.int64)  # first cell, one past the last
    for i in range(3):
        begin, end = cell_range(low[i], width, taken.shape[i], first[i] - reach, last[i] + reach)
        stack[0, i, 0], stack[0, i, 1] = begin, end
    block = np.zeros((3, 2), np.int64)
    top = 1
    while top:
        top -= 1
        copy_block(stack[top], block)
        x, y, z = block[0], block[1], block[2]
        cells = taken[x[0] : x[1], y[0] : y[1], z[0] : z[1]]
        if cells.all():
            continue
        longest, radius = 0, 0.0
        for i in range(3):
            size = block[i, 1] - block[i, 0]
            longest = i if size > block[longest, 1] - block[longest, 0] else longest
            center[i] = low[i] + 0.5 * (block[i, 0] + block[i, 1]) * width
            radius += (0.5 * (size - 1) * width) ** 2
        radius = math.sqrt(radius)
        gap = separation(shape, point)
        if radius == 0.0:
            if gap <= reach:
                cells[:] = 1
            continue
        if gap > reach + radius + slack:
            continue
        within = gap <= reach
        for corner in range(8):
            if within:
                for i in range(3):
                    cell = block[i, 0] if corner >> i & 1 else block[i, 1] - 1
                    center[i] = low[i] + (cell + 0.5) * width
                gap = separation(shape, point)
                within = gap <= reach - slack
        if within:
            cells[:] = 1
            continue
        middle = (block[longest, 0] + block[longest, 1]) // 2
        for part in range(2):
            copy_block(block, stack[top])
            stack[top, longest, 1 - part] = middle
            top += 1


@allocating_kernel
def mark_triangles(triangles, boxes, low, width, taken):  # type: ignore[no-untyped-def]
    """Mark the cells that triangles (m, 9) reach into, by the separating axes of box and triangle.

    No axis separates points, whose boxes are those of the balls around them: all cells of these
    are marked.

    Args:
        triangles: Corners in [m], shape (m, 9).
        boxes: Around them, lowest and highest x, y, z in [m], shape (m, 6).
        low, width: The grid's lowest corner, shape (3,), and a cell's width, in [m].
        taken: Whether cells are marked, shape (nx, ny, nz); written.

    Source: Akenine-Möller, Fast 3D triangle-box overlap testing, Journal of Graphics Tools 6, 2001.
    """
    corner, edge = np.zeros((3, 3)), np.zeros((3, 3))
    n, center, axis = np.zeros(3), np.zeros(3), np.zeros(3)
    ranges = np.zeros((3, 2), np.int64)
    half = 0.5 * width * (1.0 + 1e-6)
    for t in range(triangles.shape[0]):
        for c in range(3):
            for i in range(3):
                corner[c, i] = triangles[t, 3 * c + i]
        for c in range(3):
            for i in range(3):
                edge[c, i] = corner[(c + 1) % 3, i] - corner[c, i]
        for i in range(3):
            first, last = boxes[t, i], boxes[t, i + 3]
            begin, end = cell_range(low[i], width, taken.shape[i], first, last)
            ranges[i, 0], ranges[i, 1] = begin, end
            j, k = (i + 1) % 3, (i + 2) % 3
            n[i] = edge[0, j] * edge[1, k] - edge[0, k] * edge[1, j]
        offset = n[0] * corner[0, 0] + n[1] * corner[0, 1] + n[2] * corner[0, 2]
        reach = half * (abs(n[0]) + abs(n[1]) + abs(n[2]))
        slack = 1e-9 * (abs(offset) + reach)
        for i in range(ranges[0, 0], ranges[0, 1]):
            center[0] = low[0] + (i + 0.5) * width
            for j in range(ranges[1, 0], ranges[1, 1]):
                center[1] = low[1] + (j + 0.5) * width
                for k in range(ranges[2, 0], ranges[2, 1]):
                    if taken[i, j, k]:
                        continue
                    center[2] = low[2] + (k + 0.5) * width
                    away = n[0] * center[0] + n[1] * center[1] + n[2] * center[2] - offset
                    if abs(away) > reach + slack:
                        continue
                    if not edges_separate(corner, edge, center, half, axis):
                        taken[i, j, k] = 1


@kernel
def edges_separate(corner, edge, center, half, axis):  # type: ignore[no-untyped-def]
    """Say whether an axis across an edge and a coordinate parts a triangle from a cube.

    Args:
        corner, edge: Of the triangle, row by row in [m], shape (3, 3).
        center, half: The cube's, shape (3,), and half its edge, in [m].
        axis: Scratch, shape (3,).
    """
    for c in range(3):
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            axis[i], axis[j], axis[k] = 0.0, -edge[c, k], edge[c, j]
            lowest, highest = math.inf, -math.inf
            for v in range(3):
                along = axis[j] * (corner[v, j] - center[j]) + axis[k] * (corner[v, k] - center[k])
                lowest, highest = min(lowest, along), max(highest, along)
            reach = half * (abs(axis[j]) + abs(axis[k]))
            if lowest > reach or highest < -reach:
                return True
    return False


@kernel
def distance_bound(width, distance, x, y, z):  # type: ignore[no-untyped-def]
    """Bound the distance of a point to every obstacle from below, in [m]; infinite in no world.

    The point is given from the grid's lowest corner.

    Args:
        width: Of a cell in [m].
        distance: Of each cell in [m], shape (nz, ny, nx).
        x, y, z: The point in [m].
    """
    nz, ny, nx = distance.shape
    if nx == 0:
        return math.inf
    a, b, c = x / width, y / width, z / width
    i = int(min(max(a, 0.0), nx - 1.0))
    j = int(min(max(b, 0.0), ny - 1.0))
    k = int(min(max(c, 0.0), nz - 1.0))
    a, b, c = abs(a - i - 0.5), abs(b - j - 0.5), abs(c - k - 0.5)
    found = distance[k, j, i] - width * math.sqrt(a * a + b * b + c * c)
    if max(a, b, c) <= 0.5:
        return max(found, 0.0)
    # Outside of the grid all obstacles are on its other side.
    a, b, c = max(a - 0.5, 0.0), max(b - 0.5, 0.0), max(c - 0.5, 0.0)
    return max(found, width * math.sqrt(a * a + b * b + c * c), 0.0)
