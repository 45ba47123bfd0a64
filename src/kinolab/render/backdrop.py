"""What stands still, drawn once: floor, grid, goal, path, obstacles with their shadows, ghosts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.render.cone import cone_mesh
from kinolab.render.ground import annulus, grid, slab
from kinolab.render.ink import Pen
from kinolab.render.light import LAMPS, SHADOW
from kinolab.render.mesh import Mesh, is_room, join, weld
from kinolab.render.paint import Color, ball
from kinolab.render.raster import GROUND, Canvas, Facets, blank, darken, draw
from kinolab.render.scene import Ghost, GoalRegion, Picture
from kinolab.render.stroke import chain, smoothed, strokes, thinned

Array: TypeAlias = NDArray[np.float64]

PAPER = (250, 250, 248)
GRID, PATH = (212, 212, 204), (58, 110, 165)
WALL, WALL_EDGE = (0.70, 0.755, 0.815), (104, 120, 140)
START, GOAL = (0.55, 0.57, 0.60), (0.10, 0.62, 0.38)
INK = (38, 42, 50)
CONE = 0.3  # opacity
EDGE_WIDTH, GRID_WIDTH, PATH_WIDTH = 0.7, 0.9, 2.2  # [pixel]


@dataclass(frozen=True, eq=False)
class Floor:
    """The rectangle of the ground that is drawn, by two opposite corners of shape (2,), in [m]."""

    low: Array
    high: Array


def backdrop(picture: Picture, machine: Sequence[Mesh], pen: Pen, floor: Floor | None) -> Canvas:
    """Draw all that stands still on a canvas that knows depth and ground."""
    canvas = blank(pen.size, PAPER)
    if floor is not None:
        _draw_floor(canvas, floor, pen)
    if isinstance(picture.goal, GoalRegion):
        _draw_region(canvas, picture.goal, pen, floor)
    if picture.path is not None and len(picture.path) > 1:
        _draw_path(canvas, picture.path, pen, floor)
    _draw_obstacles(canvas, picture, pen, floor)
    if picture.start is not None:
        _draw_ghost(canvas, machine, picture.start, START, pen)
    if isinstance(picture.goal, Ghost):
        _draw_ghost(canvas, machine, picture.goal, GOAL, pen)
    for mesh in map(cone_mesh, picture.cones):
        _blend(canvas, mesh, CONE, pen)
    return canvas


def cast(canvas: Canvas, shadows: Sequence[Array]) -> None:
    """Darken the ground where lamps do not reach it; ``shadows`` has one entry per lamp."""
    darken(canvas, shadows, SHADOW ** (1.0 / LAMPS))


def _draw_floor(canvas: Canvas, floor: Floor, pen: Pen) -> None:
    top, sides = slab(floor.low, floor.high, 0.015 * float(np.max(floor.high - floor.low)))
    draw(canvas, pen.faces(sides))
    draw(canvas, pen.faces(top), GROUND)
    _paint_floor(canvas, pen.line(grid(floor.low, floor.high), GRID_WIDTH, GRID))


def _draw_region(canvas: Canvas, goal: GoalRegion, pen: Pen, floor: Floor | None) -> None:
    if floor is None:
        sphere = ball(np.array(goal.position), goal.radius, np.array(GOAL)).painted(GOAL)
        _blend(canvas, sphere, 0.35, pen)
        return
    disc = annulus(goal.position, (0.0, goal.radius), GOAL)
    ring = annulus(goal.position, (0.9 * goal.radius, goal.radius), GOAL)
    _paint_floor(canvas, pen.faces(disc), 0.3)
    _paint_floor(canvas, pen.faces(ring))


def _draw_path(canvas: Canvas, path: Array, pen: Pen, floor: Floor | None) -> None:
    flat = 1.0 if floor is None else np.array([1.0, 1.0, 0.0])
    curve = smoothed(np.asarray(path, dtype=np.float64) * flat)
    line = thinned(pen.at(curve), 1.5 * pen.scale)
    ribbon = strokes(chain(line), PATH_WIDTH * pen.scale, PATH)
    if floor is None:
        draw(canvas, ribbon)
    else:
        _paint_floor(canvas, ribbon)


def _draw_obstacles(canvas: Canvas, picture: Picture, pen: Pen, floor: Floor | None) -> None:
    meshes = [weld(body.vertices, body.faces, WALL) for body in picture.obstacles]
    rooms = [mesh for mesh in meshes if is_room(mesh)]
    solids = join([mesh for mesh in meshes if not is_room(mesh)])
    for room in rooms:
        draw(canvas, pen.front_faces(room))
    draw(canvas, pen.faces(solids))
    draw(canvas, pen.edges(solids, EDGE_WIDTH, WALL_EDGE))
    if floor is not None:
        cast(canvas, pen.shadows(solids))


def _draw_ghost(
    canvas: Canvas, machine: Sequence[Mesh], ghost: Ghost, color: Color, pen: Pen
) -> None:
    poses = np.asarray(ghost.poses, dtype=np.float64).reshape(-1, 12)
    placed = [mesh.moved(pose) for mesh, pose in zip(machine, poses, strict=True)]
    _blend(canvas, join(placed).painted(color), 0.45, pen)


def _paint_floor(canvas: Canvas, facets: Facets, opacity: float = 1.0) -> None:
    """Colour the visible floor; paint has no thickness, so depth plays no part."""
    width, height = canvas.size
    layer = blank((width, height), PAPER)
    draw(layer, facets, GROUND)
    _mix(canvas, layer, (layer.kind & canvas.kind & GROUND) > 0, opacity)


def _blend(canvas: Canvas, mesh: Mesh, opacity: float, pen: Pen) -> None:
    """Mix a body into the picture; it hides nothing that is drawn later."""
    width, height = canvas.size
    layer = canvas.part((0, 0, width, height))
    edge = 255.0 * 0.6 * mesh.colors[0]
    draw(layer, pen.faces(mesh) + pen.edges(mesh, EDGE_WIDTH, edge))
    _mix(canvas, layer, layer.nearness != canvas.nearness, opacity)


def _mix(canvas: Canvas, layer: Canvas, where: NDArray[np.bool_], opacity: float) -> None:
    mixed = (1.0 - opacity) * canvas.color[where] + opacity * layer.color[where]
    canvas.color[where] = (mixed + 0.5).astype(np.uint8)
