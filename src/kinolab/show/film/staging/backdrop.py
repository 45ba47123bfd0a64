"""The static backdrop: floor, grid, goal, path, obstacles with their shadows, ghosts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from kinolab.numerics.arrays import Array
from kinolab.show.film.models.ball import Color, ball
from kinolab.show.film.models.cone import cone_mesh
from kinolab.show.film.models.ground import annulus, grid, slab
from kinolab.show.film.models.surface_mesh import SurfaceMesh, is_room, join, weld
from kinolab.show.film.picture import Floor, Ghost, GoalMarker, Picture, Surface
from kinolab.show.film.raster.draw_list import FloorPaint, Layer, Shadows, Solid, Veil
from kinolab.show.film.raster.rasterizer import GROUND
from kinolab.show.film.raster.shading import Pen
from kinolab.show.film.raster.stroke import chain, smoothed, strokes, thinned

if TYPE_CHECKING:
    from kinolab.world.obstacle import Obstacle

GRID, PATH = (212, 212, 204), (58, 110, 165)
WALL, WALL_EDGE = (0.70, 0.755, 0.815), (104, 120, 140)
START, GOAL = (0.55, 0.57, 0.60), (0.10, 0.62, 0.38)
CONE_OPACITY = 0.3  # of a cone
GOAL_OPACITY = 0.35  # of a ball
EDGE_WIDTH, GRID_WIDTH, PATH_WIDTH, CABLE = 0.7, 0.9, 2.2, 1.6  # [pixel]


def backdrop(
    picture: Picture, machine: Sequence[SurfaceMesh], pen: Pen, floor: Floor | None
) -> list[Layer]:
    """Return the static layers, in drawing order."""
    layers: list[Layer] = []
    if floor is not None:
        layers += _floor(floor, pen)
    if isinstance(picture.goal, GoalMarker):
        layers += _region(picture.goal, pen, floor)
    if picture.path is not None and len(picture.path) > 1:
        layers.append(_path(picture.path, pen, floor))
    layers += _obstacles(picture, pen, floor)
    if picture.start is not None:
        layers.append(_ghost(machine, picture.start, START, pen, picture.radii))
    if isinstance(picture.goal, Ghost):
        layers.append(_ghost(machine, picture.goal, GOAL, pen, picture.radii))
    layers += [_veil(goal_ball(point), GOAL_OPACITY, pen) for point in picture.points]
    return layers + [_veil(cone_mesh(cone), CONE_OPACITY, pen) for cone in picture.cones]


def obstacle_mesh(obstacle: Obstacle | Surface) -> SurfaceMesh:
    """Return an obstacle in its own colours, or in that of walls."""
    colors = WALL if obstacle.colors is None else obstacle.colors
    return weld(obstacle.vertices, obstacle.faces, colors)


def goal_ball(goal: GoalMarker) -> SurfaceMesh:
    """Return the ball that a point must enter."""
    return ball(np.array(goal.position), goal.radius, np.array(GOAL)).painted(GOAL)


def _floor(floor: Floor, pen: Pen) -> Iterator[Layer]:
    top, sides = slab(floor.low, floor.high, 0.015 * float(np.max(floor.high - floor.low)))
    yield Solid(pen.faces(sides))
    yield Solid(pen.faces(top), GROUND)
    yield FloorPaint(pen.line(grid(floor.low, floor.high), GRID_WIDTH, GRID))


def _region(goal: GoalMarker, pen: Pen, floor: Floor | None) -> Iterator[Layer]:
    if floor is None:
        yield _veil(goal_ball(goal), GOAL_OPACITY, pen)
        return
    yield FloorPaint(pen.faces(annulus(goal.position, (0.0, goal.radius), GOAL)), 0.3)
    yield FloorPaint(pen.faces(annulus(goal.position, (0.9 * goal.radius, goal.radius), GOAL)))


def _path(path: Array, pen: Pen, floor: Floor | None) -> Layer:
    flat = 1.0 if floor is None else np.array([1.0, 1.0, 0.0])
    curve = smoothed(np.asarray(path, dtype=np.float64) * flat)
    line = thinned(pen.at(curve), 1.5 * pen.scale)
    ribbon = strokes(chain(line), PATH_WIDTH * pen.scale, PATH)
    return Solid(ribbon) if floor is None else FloorPaint(ribbon)


def _obstacles(picture: Picture, pen: Pen, floor: Floor | None) -> Iterator[Layer]:
    meshes = [obstacle_mesh(obstacle) for obstacle in picture.obstacles]
    rooms = [mesh for mesh in meshes if is_room(mesh)]
    solids = join([mesh for mesh in meshes if not is_room(mesh)])
    for room in rooms:
        yield Solid(pen.front_faces(room))
    yield Solid(pen.faces(solids))
    yield Solid(pen.edges(solids, EDGE_WIDTH, WALL_EDGE))
    if floor is not None:
        yield Shadows(pen.shadows(solids))


def _ghost(
    machine: Sequence[SurfaceMesh], ghost: Ghost, color: Color, pen: Pen, radii: Array
) -> Layer:
    poses = np.asarray(ghost.poses, dtype=np.float64).reshape(-1, 12)
    placed = [mesh.moved(pose) for mesh, pose in zip(machine, poses, strict=True)]
    veil = _veil(join(placed).painted(color), 0.45, pen)
    return replace(veil, facets=veil.facets + pen.line(ghost.lines, CABLE, _edge(color), radii))


def _veil(mesh: SurfaceMesh, opacity: float, pen: Pen) -> Veil:
    return Veil(pen.faces(mesh) + pen.edges(mesh, EDGE_WIDTH, _edge(mesh.colors[0])), opacity)


def _edge(color: ArrayLike) -> Array:
    return 255.0 * 0.6 * np.asarray(color)
