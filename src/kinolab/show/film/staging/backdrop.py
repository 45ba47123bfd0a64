"""The static backdrop: floor, grid, goal, path, obstacles with their shadows, ghosts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.film.raster.draw_list import FloorPaint, Layer, Shadows, Sky, Solid, Veil
from kinolab.show.film.raster.rasterizer import GROUND
from kinolab.show.film.raster.shading import Pen
from kinolab.show.film.raster.stroke import chain, smoothed, strokes, thinned
from kinolab.show.scene.models.ball import Color
from kinolab.show.scene.models.cone import cone_mesh
from kinolab.show.scene.models.ground import annulus, marked_areas, marked_lines, slab
from kinolab.show.scene.models.setting import SceneColors
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, is_room, join
from kinolab.show.scene.picture import Floor, Ghost, GoalMarker
from kinolab.show.scene.still import GOAL, PATH, START, Still, goal_ball

WALL_EDGE = 0.62  # of the colour of an obstacle's faces: how bright its edges are
CONE_OPACITY, DARK_CONE_OPACITY = 0.3, 0.55  # of a cone, and of one before a dark sky
GOAL_OPACITY = 0.35  # of a ball
EDGE_WIDTH, GRID_WIDTH, PATH_WIDTH, CABLE = 0.7, 0.9, 2.2, 1.6  # [pixel]


def backdrop(still: Still, machine: Sequence[SurfaceMesh], pen: Pen) -> list[Layer]:
    """Return the static layers, in drawing order."""
    picture, floor = still.picture, still.floor
    top, foot = (255.0 * np.array(color) for color in picture.colors.sky)
    layers: list[Layer] = [Sky(top, foot, pen.size[1])]
    if floor is not None:
        layers += _floor(floor, picture.colors, pen)
    if isinstance(picture.goal, GoalMarker):
        layers += _region(picture.goal, pen, floor)
    if picture.path is not None and len(picture.path) > 1:
        drawn = floor if picture.rolls else None
        layers += [_path(path, pen, drawn) for path in (picture.path, *picture.others)]
    layers += _obstacles(still, pen)
    if picture.start is not None:
        layers.append(_ghost(machine, picture.start, START, pen, picture.radii))
    if isinstance(picture.goal, Ghost):
        layers.append(_ghost(machine, picture.goal, GOAL, pen, picture.radii))
    layers += [_veil(goal_ball(point), GOAL_OPACITY, pen) for point in picture.points]
    opacity = DARK_CONE_OPACITY if picture.colors.is_dark else CONE_OPACITY
    return layers + [_veil(cone_mesh(cone), opacity, pen) for cone in picture.cones]


def _floor(floor: Floor, colors: SceneColors, pen: Pen) -> Iterator[Layer]:
    thickness = 0.015 * float(np.max(floor.high - floor.low))
    top, sides = slab(floor.low, floor.high, thickness, colors)
    yield Solid(pen.faces(sides))
    yield Solid(pen.faces(top), GROUND)
    yield from (FloorPaint(pen.faces(area)) for area in marked_areas(floor.low, floor.high, colors))
    lines = marked_lines(floor.low, floor.high, colors)
    if len(lines):
        yield FloorPaint(pen.line(lines, GRID_WIDTH, 255.0 * np.array(colors.lines)))


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


def _obstacles(still: Still, pen: Pen) -> Iterator[Layer]:
    parts = list(zip(still.obstacles, still.outlook.veiled, strict=True))
    rooms = [(mesh, veiled) for mesh, veiled in parts if is_room(mesh)]
    solids = join([_shown(mesh, veiled) for mesh, veiled in parts if not is_room(mesh)])
    for mesh, veiled in rooms:
        yield Solid(pen.front_faces(_shown(mesh, veiled)))
        # 1.6 [pixel] of the outline of a room, into which one looks
        yield Solid(pen.silhouette(mesh, 1.6, 255.0 * WALL_EDGE * mesh.colors[0]))
    yield Solid(pen.faces(solids))
    yield Solid(pen.edges(solids, EDGE_WIDTH, 255.0 * WALL_EDGE * solids.colors))
    if still.floor is not None:
        yield Shadows(pen.shadows(solids))
    veils = [mesh.only(veiled) for mesh, veiled in parts if veiled.any()]
    yield from (_veil(mesh, 0.14, pen) for mesh in veils)  # of walls that hide the way


def _shown(mesh: SurfaceMesh, veiled: NDArray[np.bool_]) -> SurfaceMesh:
    return mesh.only(~veiled) if veiled.any() else mesh


def _ghost(
    machine: Sequence[SurfaceMesh], ghost: Ghost, color: Color, pen: Pen, radii: Array
) -> Layer:
    veil = _veil(join(ghost.placed(machine)).painted(color), 0.45, pen)
    return replace(veil, facets=veil.facets + pen.line(ghost.lines, CABLE, _edge(color), radii))


def _veil(mesh: SurfaceMesh, opacity: float, pen: Pen) -> Veil:
    return Veil(pen.faces(mesh) + pen.edges(mesh, EDGE_WIDTH, _edge(mesh.colors)), opacity)


def _edge(color: ArrayLike) -> Array:
    return 255.0 * 0.6 * np.asarray(color)
