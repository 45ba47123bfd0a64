"""The stage of a film: the camera that sees everything, the machine's colours, the backdrop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.film.models.assembly import Assembly
from kinolab.show.film.models.cone import cone_mesh
from kinolab.show.film.models.surface_mesh import SurfaceMesh
from kinolab.show.film.picture import Floor, Ghost, GoalMarker, Picture, pose_table
from kinolab.show.film.raster.camera import Camera, frame_scene
from kinolab.show.film.raster.shading import pen
from kinolab.show.film.scene import SUPERSAMPLING, Scene
from kinolab.show.film.staging.backdrop import Still, backdrop
from kinolab.show.film.staging.viewpoint import outlook


def build_scene(picture: Picture, motion: Array, size: tuple[int, int]) -> Scene:
    """Place the camera to frame everything, and set up the backdrop.

    Args:
        picture: The picture to draw.
        motion: Poses that the picture must contain, shape (nt, nb, 12).
        size: Width and height of the picture in [pixel].
    """
    still, camera = placed(picture, motion, size)
    up = np.asarray(picture.up, dtype=np.float64) / np.linalg.norm(picture.up)
    tool = pen(camera, size, up, SUPERSAMPLING)
    machine = picture.machine(nearest_pixel(camera, still.machine, motion, size))
    layers, body = backdrop(still, machine, tool), Assembly(machine, picture.radii)
    return Scene(tool, body, layers, still)


def placed(picture: Picture, motion: Array, size: tuple[int, int]) -> tuple[Still, Camera]:
    """What stands still, and the camera that sees it; the motion's poses are (nt, nb, 12)."""
    machine = picture.machine()
    obstacles = picture.obstacle_meshes()
    cloud = seen_points(picture, obstacles, machine, motion)
    floor = floor_under(cloud) if picture.stands_on_ground else None
    if floor is not None:
        cloud = np.concatenate([cloud, _corners(floor)])
    look = outlook(picture, obstacles, cloud, motion)
    camera = frame_scene(cloud, picture.up, picture.view, size, angles=look.angles)
    largest = float(np.ptp(cloud, axis=0).max())
    return Still(picture, obstacles, look, floor, largest, machine), camera


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
    tables = [motion, *(pose_table(ghost.poses)[None] for ghost in ghosts)]
    for table in tables:
        parts += [swept(mesh, table[:, i]) for i, mesh in enumerate(machine) if len(mesh.faces)]
    parts += [np.asarray(ghost.lines, dtype=np.float64) for ghost in ghosts]
    if picture.path is not None:
        parts.append(np.asarray(picture.path, dtype=np.float64))
    if isinstance(picture.goal, GoalMarker):
        reach = picture.goal.radius * np.concatenate([np.eye(3), -np.eye(3)])
        level = np.array([1.0, 1.0, 0.0 if picture.stands_on_ground else 1.0])
        parts.append((np.array(picture.goal.position) + reach) * level)
    for point in picture.points:
        parts.append(point.position + point.radius * np.concatenate([np.eye(3), -np.eye(3)]))
    parts += [cone_mesh(cone).vertices for cone in picture.cones]
    if picture.lines is not None and not callable(picture.lines):
        parts.append(np.asarray(picture.lines, dtype=np.float64))
    found = np.concatenate([np.zeros((0, 3)), *(part.reshape(-1, 3) for part in parts)])
    found = found[np.isfinite(found).all(axis=1)]
    if len(found) == 0:
        found = np.zeros((1, 3))  # an empty world is viewed from near its origin
    return np.concatenate([found, _bounds(picture, found)])


def swept(mesh: SurfaceMesh, poses: Array) -> Array:
    """The corners of a mesh's own bounding box at every pose, shape (nt, 8, 3)."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    corners = np.array([np.where(pick, high, low) for pick in np.ndindex(2, 2, 2)])
    g = poses.reshape(-1, 3, 4)
    return np.asarray(np.einsum("tij,kj->tki", g[:, :, :3], corners) + g[:, None, :, 3])


def _bounds(picture: Picture, found: Array) -> Array:
    """The corners of the workspace; an axis without finite limits adds no extent of its own."""
    box = np.stack([found.min(axis=0)] * 2)
    for k, axis in enumerate("xyz"):
        limits = np.array(picture.bounds.get(axis, (np.nan, np.nan)))
        if np.isfinite(limits).all():
            box[:, k] = limits
    return np.array([[box[i, 0], box[j, 1], box[k, 2]] for i, j, k in np.ndindex(2, 2, 2)])


def floor_under(cloud: Array) -> Floor:
    """Return the rectangle of the ground below points of shape (n, 3), with a margin."""
    low, high = cloud[:, :2].min(axis=0), cloud[:, :2].max(axis=0)
    margin = 0.02 * float(np.max(high - low))
    return Floor(low - margin, high + margin)


def _corners(floor: Floor) -> Array:
    (x0, y0), (x1, y1) = floor.low, floor.high
    return np.array([[x, y, 0.0] for x in (x0, x1) for y in (y0, y1)])
