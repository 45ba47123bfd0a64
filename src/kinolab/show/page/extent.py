"""Extent of a page's scene: the convex hull of its content, and the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kinolab.numerics.arrays import Array
from kinolab.show.film.models.surface_mesh import SurfaceMesh
from kinolab.show.film.picture import Floor
from kinolab.show.film.staging.stage import floor_under, seen_points
from kinolab.show.page.content import Content


def extent(content: Content, machine: Sequence[SurfaceMesh]) -> tuple[Array, Floor | None]:
    """Return points whose convex hull contains everything, shape (n, 3), and the floor if any.

    Without a floor, the workspace's bounds are not shown, and are left out.
    """
    picture = content.picture
    if not picture.stands_on_ground:
        picture = replace(picture, bounds={})
    cloud = seen_points(picture, tuple(machine), _shown(content))
    floor = floor_under(cloud) if picture.stands_on_ground else None
    if floor is not None:
        (a, b), (c, d) = floor.low, floor.high
        cloud = np.concatenate([cloud, [[a, b, 0.0], [a, d, 0.0], [c, b, 0.0], [c, d, 0.0]]])
    return _hull(cloud), floor


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
