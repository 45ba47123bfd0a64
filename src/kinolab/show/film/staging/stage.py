"""The stage of a film: the camera that sees everything, the machine's colours, the backdrop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.film.models.assembly import Assembly
from kinolab.show.film.models.cone import cone_mesh
from kinolab.show.film.models.surface_mesh import SurfaceMesh
from kinolab.show.film.picture import Floor, Ghost, GoalMarker, Picture
from kinolab.show.film.raster.camera import Camera, frame_scene
from kinolab.show.film.raster.shading import pen
from kinolab.show.film.scene import SUPERSAMPLING, Scene
from kinolab.show.film.staging.backdrop import Still, backdrop
from kinolab.show.film.staging.frame_axes import axes_of, axis_length, reach_of
from kinolab.show.film.staging.viewpoint import outlook


def build_scene(picture: Picture, motion: Array, size: tuple[int, int]) -> Scene:
    """Place the camera to frame everything, and set up the backdrop.

    Args:
        picture: The picture to draw.
        motion: Poses that the picture must contain, shape (nt, nb, 12).
        size: Width and height of the picture in [pixel].
    """
    still, cloud = set_up(picture, motion)
    camera = frame_scene(cloud, picture.up, picture.view, size, angles=still.outlook.angles)
    up = np.asarray(picture.up, dtype=np.float64) / np.linalg.norm(picture.up)
    tool = pen(camera, size, up, SUPERSAMPLING)
    machine = picture.machine(nearest_pixel(camera, still.machine, motion, size))
    layers, body = backdrop(still, machine, tool), Assembly(machine, picture.radii)
    return Scene(tool, body, layers, still)


def set_up(picture: Picture, motion: Array) -> tuple[Still, Array]:
    """What stands still, and points whose convex hull has all that is seen, shape (n, 3), in [m].

    Args:
        picture: The picture.
        motion: Poses that it must contain, shape (nt, nb, 12).
    """
    machine, obstacles = picture.machine(), picture.obstacle_meshes()
    cloud, floor = seen_points(picture, obstacles, machine, motion), None
    reach, largest = reach_of(machine, motion), float(np.ptp(cloud, axis=0).max())
    if picture.frames is not None:
        length = axis_length(reach, largest, len(picture.frames.names))
        cloud = np.concatenate([cloud, axes_of(picture.frames.poses, length).reshape(-1, 3)])
    if picture.stands_on_ground:
        low, high = cloud[:, :2].min(axis=0), cloud[:, :2].max(axis=0)
        margin = 0.02 * float(np.max(high - low))
        floor = Floor(low - margin, high + margin)
        flat = box_corners(np.append(floor.low, 0.0), np.append(floor.high, 0.0))[::2]
        cloud = np.concatenate([cloud, flat])
    look = outlook(picture, obstacles, cloud, motion)
    return Still(picture, obstacles, look, floor, largest, machine, reach), cloud


def nearest_pixel(
    camera: Camera, machine: Sequence[SurfaceMesh], motion: Array, size: tuple[int, int]
) -> float:
    """Size of a pixel in [m] where a motion (nt, nb, 12) comes nearest to the camera."""
    paths = [swept(mesh, motion[:, i]) for i, mesh in enumerate(machine) if len(mesh.faces)]
    if not paths:
        return 0.0
    nearest = min(float(camera.project(path, size)[..., 2].min()) for path in paths)
    return float(2.0 * nearest * np.tan(0.5 * camera.fov) / size[1])


def seen_points(
    picture: Picture,
    obstacles: Sequence[SurfaceMesh],
    machine: tuple[SurfaceMesh, ...],
    motion: Array,
) -> Array:
    """Points whose convex hull contains everything that is drawn, shape (n, 3)."""
    parts = [mesh.vertices for mesh in obstacles]
    ghosts = [ghost for ghost in (picture.start, picture.goal) if isinstance(ghost, Ghost)]
    tables = [motion, *(ghost.table[None] for ghost in ghosts)]
    for table in tables:
        parts += [swept(mesh, table[:, i]) for i, mesh in enumerate(machine) if len(mesh.faces)]
    parts += [np.asarray(ghost.lines, dtype=np.float64) for ghost in ghosts]
    if picture.path is not None:
        parts.append(np.asarray(picture.path, dtype=np.float64))
    ways = np.concatenate([np.eye(3), -np.eye(3)])
    if isinstance(picture.goal, GoalMarker):
        level = np.array([1.0, 1.0, 0.0 if picture.stands_on_ground else 1.0])
        parts.append((np.array(picture.goal.position) + picture.goal.radius * ways) * level)
    parts += [point.position + point.radius * ways for point in picture.points]
    parts += [cone_mesh(cone).vertices for cone in picture.cones]
    if picture.lines is not None:
        parts.append(np.asarray(picture.lines, dtype=np.float64))
    found = np.concatenate([np.zeros((0, 3)), *(part.reshape(-1, 3) for part in parts)])
    found = found[np.isfinite(found).all(axis=1)]
    if len(found) == 0:
        found = np.zeros((1, 3))  # an empty world is viewed from near its origin
    return np.concatenate([found, _bounds(picture, found)])


def swept(mesh: SurfaceMesh, poses: Array) -> Array:
    """The corners of a mesh's own bounding box at every pose, shape (nt, 8, 3)."""
    corners = box_corners(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0))
    g = poses.reshape(-1, 3, 4)
    return np.asarray(np.einsum("tij,kj->tki", g[:, :, :3], corners) + g[:, None, :, 3])


def _bounds(picture: Picture, found: Array) -> Array:
    """The corners of the workspace; an axis without finite limits adds no extent of its own."""
    box = np.stack([found.min(axis=0)] * 2)
    for k, axis in enumerate("xyz"):
        limits = np.array(picture.bounds.get(axis, (np.nan, np.nan)))
        if np.isfinite(limits).all():
            box[:, k] = limits
    return box_corners(*box)


def box_corners(low: Array, high: Array) -> Array:
    """The corners of a box between two opposite ones, shape (8, 3)."""
    return np.array([np.where(pick, high, low) for pick in np.ndindex(2, 2, 2)])
