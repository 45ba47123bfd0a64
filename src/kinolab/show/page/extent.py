"""Extent of a page's scene: the convex hull of its content, and the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kinolab.numerics.arrays import Array
from kinolab.show.film.models.surface_mesh import SurfaceMesh
from kinolab.show.film.picture import Floor
from kinolab.show.film.staging.stage import floor_under, seen_points
from kinolab.show.film.staging.viewpoint import Outlook, outlook
from kinolab.show.page.content import Content


@dataclass(frozen=True, eq=False)
class Extent:
    """What is seen of a page's scene, and from where.

    Attributes:
        hull: Points whose convex hull contains everything, shape (n, 3), in [m].
        floor: The ground, if there is any.
        obstacles: The obstacles as meshes.
        outlook: From where one sees most of the way.
        machine: Its bodies as meshes.
        motion: Where they are along the way, shape (n, nb, 12).
    """

    hull: Array
    floor: Floor | None
    obstacles: Sequence[SurfaceMesh]
    outlook: Outlook
    machine: Sequence[SurfaceMesh]
    motion: Array

    @property
    def reach(self) -> float:
        """How far the machine reaches from the middle of its bodies, in [m]."""
        origins = self.motion[..., 3::4]
        away = np.linalg.norm(origins - origins.mean(axis=1, keepdims=True), axis=-1).max(axis=0)
        sizes = [np.linalg.norm(m.vertices, axis=1).max(initial=0.0) for m in self.machine]
        return float(max(np.max(away + np.array(sizes)), 1e-3))


@lru_cache(maxsize=1)  # page and GLB of a plan have the same scene
def extent(content: Content) -> Extent:
    """Return what is seen of a page's scene.

    Without a floor, the workspace's bounds are not shown, and are left out.
    """
    picture, machine = content.picture, content.picture.machine()
    if not picture.stands_on_ground:
        picture = replace(picture, bounds={})
    obstacles, motion = picture.obstacle_meshes(), _shown(content)
    cloud = seen_points(picture, obstacles, machine, motion)
    floor = floor_under(cloud) if picture.stands_on_ground else None
    if floor is not None:
        (a, b), (c, d) = floor.low, floor.high
        cloud = np.concatenate([cloud, [[a, b, 0.0], [a, d, 0.0], [c, b, 0.0], [c, d, 0.0]]])
    look = outlook(replace(picture, view="perspective"), obstacles, cloud, motion)
    return Extent(_hull(cloud), floor, obstacles, look, machine, motion)


def _hull(cloud: Array) -> Array:
    """Return the vertices of the convex hull, or of the bounding box if it is degenerate."""
    try:
        return np.asarray(cloud[ConvexHull(cloud).vertices])
    except QhullError:  # coplanar points
        ends = np.stack([cloud.min(axis=0), cloud.max(axis=0)])
        return np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i, j, k in np.ndindex(2, 2, 2)])


def _shown(content: Content) -> Array:
    """Return poses that the picture must contain, shape (n, nb, 12)."""
    places = [curve.values for curve in content.keys.places]
    n = min(len(values) for values in places)
    rows = [values[np.linspace(0, len(values) - 1, n).astype(int)] for values in places]
    poses = np.zeros((n, len(rows), 3, 4))
    poses[..., :3], poses[..., 3] = np.eye(3), np.stack(rows, axis=1)
    return poses.reshape(n, -1, 12)
