"""What stands still in a picture, how it is looked at, and how far all that is seen reaches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.scene.content import Content
from kinolab.show.scene.frame_axes import axes_of, axis_length, reach_of
from kinolab.show.scene.models.ball import ball
from kinolab.show.scene.models.cone import cone_mesh
from kinolab.show.scene.models.painted_body import fineness
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, weld
from kinolab.show.scene.picture import Floor, Ghost, GoalMarker, Picture
from kinolab.show.scene.viewpoint import Outlook, outlook

BRIGHT, DARK = (255, 255, 255), (22, 24, 32)  # around dark letters, and around bright ones
INK, PATH = (38, 42, 50), (58, 110, 165)
START, GOAL = (0.55, 0.57, 0.60), (0.0, 0.48, 0.25)


@dataclass(frozen=True, eq=False)
class Still:
    """What stands still in a picture, and how it is looked at.

    Args:
        obstacles: Its obstacles as meshes.
        outlook: Where it is seen from, and what is translucent.
        floor: The ground, if there is any.
        size: Of all that is seen, in [m].
        machine: The bodies in their finest detail.
        reach: How far they reach from their middle, in [m].
        paths: Where the corners of their own bounding boxes are along the way, as ``paths_of``.
    """

    picture: Picture
    obstacles: Sequence[SurfaceMesh]
    outlook: Outlook
    floor: Floor | None
    size: float
    machine: Sequence[SurfaceMesh]
    reach: float
    paths: Sequence[Array]

    @property
    def words(self) -> tuple[int, int, int]:
        """The colour of title and labels, RGB in 0..255."""
        red, green, blue = (round(255.0 * part) for part in self.picture.colors.words)
        return red, green, blue

    @property
    def around(self) -> tuple[int, int, int]:
        """What surrounds letters that stand before all kinds of things, RGB in 0..255."""
        return DARK if self.picture.colors.is_dark else BRIGHT


@dataclass(frozen=True, eq=False)
class Extent:
    """What is seen of a page's scene, and from where.

    Attributes:
        still: What stands still, and from where one sees most of the way.
        hull: Points whose convex hull contains everything, shape (n, 3), in [m].
        motion: Where the bodies are along the way, shape (n, nb, 12).
    """

    still: Still
    hull: Array
    motion: Array


@lru_cache(maxsize=1)  # page and GLB of a plan have the same scene
def extent(content: Content) -> Extent:
    """Return what is seen of a page's scene.

    Without a floor, the workspace's bounds are not shown, and are left out.
    """
    picture, motion = replace(content.picture, view="perspective"), _shown(content)
    if not picture.stands_on_ground:
        picture = replace(picture, bounds={})
    still, cloud = set_up(picture, motion)
    return Extent(still, _hull(cloud), motion)


def set_up(picture: Picture, motion: Array) -> tuple[Still, Array]:
    """What stands still, and points whose convex hull has all that is seen, shape (n, 3), in [m].

    Args:
        motion: Poses that it must contain, shape (nt, nb, 12).
    """
    machine, obstacles = picture.machine(), picture.obstacle_meshes()
    paths, floor = paths_of(machine, motion), None
    cloud = seen_points(picture, obstacles, machine, paths)
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
    look = outlook(picture, obstacles, cloud, motion, machine)
    return Still(picture, obstacles, look, floor, largest, machine, reach, paths), cloud


def seen_points(
    picture: Picture,
    obstacles: Sequence[SurfaceMesh],
    machine: Sequence[SurfaceMesh],
    paths: Sequence[Array],
) -> Array:
    """Points whose convex hull contains everything that is drawn, shape (n, 3)."""
    parts = [*(mesh.vertices for mesh in obstacles), *paths]
    ghosts = [ghost for ghost in (picture.start, picture.goal) if isinstance(ghost, Ghost)]
    for ghost in ghosts:
        parts += paths_of(machine, ghost.table[None])
    parts += [np.asarray(ghost.lines, dtype=np.float64) for ghost in ghosts]
    if picture.path is not None:
        parts += [np.asarray(path, dtype=np.float64) for path in (picture.path, *picture.others)]
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


def paths_of(machine: Sequence[SurfaceMesh], motion: Array) -> list[Array]:
    """The corners of the bounding box of each body that is drawn, at every pose, (nt, 8, 3) each.

    Args:
        machine: A mesh of each body.
        motion: Their poses, shape (nt, nb, 12).
    """
    paths = []
    for i, mesh in enumerate(machine):
        if len(mesh.faces):
            corners = box_corners(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0))
            g = motion[:, i].reshape(-1, 3, 4)
            turned = np.einsum("tij,kj->tki", g[:, :, :3], corners)
            paths.append(np.asarray(turned + g[:, None, :, 3]))
    return paths


def goal_ball(goal: GoalMarker) -> SurfaceMesh:
    """Return the ball that a point must enter."""
    points, faces, colors = ball(goal.radius, np.array(GOAL), fineness(goal.radius, 0.0))
    return weld(np.asarray(goal.position) + points, faces, colors).painted(GOAL)


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


def _hull(cloud: Array) -> Array:
    """Return the vertices of the convex hull, or of the bounding box if it is degenerate."""
    from scipy.spatial import ConvexHull, QhullError  # late: a film needs none

    try:
        return np.asarray(cloud[ConvexHull(cloud).vertices])
    except QhullError:  # coplanar points
        return box_corners(cloud.min(axis=0), cloud.max(axis=0))


def _shown(content: Content) -> Array:
    """Return poses that the picture must contain, shape (n, nb, 12)."""
    places = [curve.values for curve in content.keys.places]
    n = min(len(values) for values in places)
    rows = [values[np.linspace(0, len(values) - 1, n).astype(int)] for values in places]
    poses = np.zeros((n, len(rows), 3, 4))
    poses[..., :3], poses[..., 3] = np.eye(3), np.stack(rows, axis=1)
    return poses.reshape(n, -1, 12)
