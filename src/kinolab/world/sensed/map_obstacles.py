"""Maps as obstacles: walls on occupied cells, and the surface of what is high.

Walls are boxes on rectangles of cells, all of them in one mesh: each is a closed part of its own,
so that triangle trees, distance grids and pictures serve it as they serve any mesh.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.untrusted import read, refuse_many
from kinolab.world.meshes.mesh import check, locate
from kinolab.world.meshes.mesh_components import Components, components
from kinolab.world.meshes.mesh_reading import refusal
from kinolab.world.obstacles.obstacle import ORIGIN, Numbers, Obstacle, placed
from kinolab.world.sensed.cell_rectangles import rectangles
from kinolab.world.sensed.map_file import (
    OCCUPIED,
    UNKNOWN,
    OccupancyMap,
    lightness,
    read_map,
    required,
)
from kinolab.world.shapes.shape_surfaces import BOX_FACES, Faces, box_surface

HEIGHT = 1.0  # [m] of walls where nothing is said

BEYOND = ' The map does not know what is there: begin and end elsewhere, or write unknown = "free".'


def map_obstacles(
    name: str,
    path: str,
    root: Path,
    position: Numbers = ORIGIN,
    rpy: Numbers = ORIGIN,
    *,
    resolution: float | None = None,
    height: float = HEIGHT,
    unknown: Literal["occupied", "free"] = "occupied",
) -> tuple[Obstacle, ...]:
    """Read a map and raise walls on its occupied cells; those on unknown cells are an obstacle too.

    Args:
        name: What the user calls it in reports.
        path: The file, looked up from ``root``, which it may not leave.
        position: Where the map's own origin goes, [m]; walls stand at this height.
        rpy: Roll, pitch, yaw in [rad].
        resolution: Edge of a cell in [m], of files that say none.
        height: Of the walls in [m].
        unknown: What unknown cells are.

    Raises:
        InputError: If the file is unusable, or has no wall.
    """
    found = read_map(path, root=root, resolution=resolution)
    x, y, yaw = found.origin
    own = placed(name, (x, y, 0.0), (0.0, 0.0, yaw))
    pose = _composed(placed(name, position, rpy), own)
    source = (root / path).resolve()
    kinds = {name: OCCUPIED}
    if unknown == "occupied":
        kinds[f"{name} unknown"] = UNKNOWN
    walls = []
    for called, kind in kinds.items():
        marked = found.cells == kind
        if marked.any():
            told = f"{_cells(found)}, {'unknown' if kind == UNKNOWN else 'occupied'} ones"
            wall = _walls(called, path, marked, found.resolution, height, pose, told, source)
            walls.append(replace(wall, remedy=BEYOND if kind == UNKNOWN else ""))
    if not walls:
        what = "has no occupied cell."
        raise refusal(
            path, what, "Leave it out; or are negate or the thresholds another way round?"
        )
    return tuple(walls)


def relief_obstacle(
    name: str,
    path: str,
    root: Path,
    position: Numbers = ORIGIN,
    rpy: Numbers = ORIGIN,
    *,
    relief: float,
    resolution: float | None = None,
    height: float = HEIGHT,
    max_slope: float | None = None,
) -> Obstacle:
    """Read heights from a picture: the block below them, or walls where they are too steep.

    Between the middles of four pixels are two triangles. The lower left pixel's middle is at the
    origin.

    Args:
        name, path, root, position, rpy, height: As of ``map_obstacles``.
        relief: How much higher white is than black, in [m].
        resolution: Distance of two pixels in [m].
        max_slope: In [rad]: the ground is the plane, and steeper squares of it are walls.

    Raises:
        InputError: If the file is unusable.
    """
    file = locate(path, root, ("png", "pgm"), "picture")
    light = lightness(path, read(file, "map", path, "Crop the picture."))
    width = required(path, resolution)
    z = relief * light.mean(axis=2, dtype=np.float64)[::-1]
    if min(z.shape) < 2:
        raise refusal(path, "has fewer than 2 x 2 pixels.", "Save it again.")
    pose, source = placed(name, position, rpy), (root / path).resolve()
    size = f"heights of {z.shape[1]} x {z.shape[0]} pixels, {width:g} m apart"
    if max_slope is not None:
        marked = _steepest(z, width) > math.tan(max_slope)
        if not marked.any():
            what = f"is nowhere steeper than {max_slope:g} rad."
            raise refusal(path, what, "Leave it out, or lower max_slope.")
        told = f"{size}; ground steeper than {max_slope:g} rad"
        walls = _walls(name, path, marked, width, height, pose, told, source)
        plane = "elsewhere machines stay in the plane, as if the ground were level"
        return replace(walls, told=f"{walls.told}; {plane}")
    vertices, faces = _block(path, z, width)
    vertices = vertices @ pose[:, :3].T + pose[:, 3]
    check(path, vertices, faces)
    parts = components(vertices, faces, np.zeros(len(faces), np.int64))
    told = f"{size}, a block below {2 * (z.shape[0] - 1) * (z.shape[1] - 1)} triangles"
    return Obstacle(name, vertices, faces, None, True, source, parts=parts, told=told)


def _composed(outer: Array, inner: Array) -> Array:
    return np.column_stack([outer[:, :3] @ inner[:, :3], outer[:, :3] @ inner[:, 3] + outer[:, 3]])


def _cells(found: OccupancyMap) -> str:
    rows, columns = found.cells.shape
    return f"map of {columns} x {rows} cells of {found.resolution:g} m"


def _walls(
    name: str,
    where: str,
    marked: NDArray[np.bool_],
    width: float,
    height: float,
    pose: Array,
    told: str,
    source: Path,
) -> Obstacle:
    """Raise boxes on the marked cells (ny, nx) of a grid, whose corner is at the pose's origin."""
    found = rectangles(marked)
    remedy = "Join cells to larger ones, or crop it."
    refuse_many(len(found) * len(BOX_FACES), "triangles", where, remedy)
    low = np.zeros((len(found), 3))
    high = np.full((len(found), 3), height)
    low[:, :2], high[:, :2] = width * found[:, [1, 0]], width * found[:, [3, 2]]
    half, (corners, one) = 0.5 * (high - low), box_surface(np.ones(3))
    # a corner is where its cell's is to the last bit, so that boxes side by side leave no gap
    local = np.where(corners > 0.0, high[:, None], low[:, None]).reshape(-1, 3)
    vertices = local @ pose[:, :3].T + pose[:, 3]
    faces = (one + len(corners) * np.arange(len(found))[:, None, None]).reshape(-1, 3)
    check(where, vertices, faces)
    label = np.repeat(np.arange(len(found)), len(one))
    parts = Components(label, 8.0 * half.prod(axis=1))
    told = f"{told} as {len(found)} boxes, exactly, {height:g} m high from z = {pose[2, 3]:g} m on"
    return Obstacle(name, vertices, faces, None, True, source, parts=parts, told=told)


def _steepest(z: Array, width: float) -> Array:
    """Return the larger gradient of both triangles of each square between heights (ny, nx)."""
    a, b, c, d = z[:-1, :-1], z[:-1, 1:], z[1:, 1:], z[1:, :-1]
    return np.maximum(np.hypot(b - a, c - b), np.hypot(c - d, d - a)) / width


def _block(where: str, z: Array, width: float) -> tuple[Array, Faces]:
    """Return the closed surface of what is below heights (ny, nx), a width deep at least."""
    rows, columns = z.shape
    triangles = 2 * (rows - 1) * (columns - 1)
    refuse_many(triangles, "triangles", where, "Scale it down, or crop it.")
    number = np.arange(rows * columns).reshape(rows, columns)
    y, x = np.divmod(number, columns)
    top = np.stack([width * x, width * y, z], axis=-1).reshape(-1, 3)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    upper = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    sides = number[0, :-1], number[:-1, -1], number[-1, :0:-1], number[:0:-1, 0]
    ring = np.concatenate(sides)  # anticlockwise, seen from above
    floor = z.min() - width
    below = np.append(top[ring], 0.5 * (top[:1] + top[-1:]), axis=0)
    below[:, 2] = floor
    start = len(top) + np.arange(len(ring))
    end, middle = np.roll(start, -1), np.full(len(ring), len(top) + len(ring))
    around = [(start, end, np.roll(ring, -1)), (start, np.roll(ring, -1), ring)]
    lower = np.array([*around, (middle, end, start)]).transpose(0, 2, 1).reshape(-1, 3)
    return np.concatenate([top, below]), np.concatenate([upper, lower]).astype(np.int64)
