"""Extent of a page's scene: the convex hull of its content, and the floor."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kinolab.numerics.arrays import Array
from kinolab.show.film.staging.backdrop import Still
from kinolab.show.film.staging.stage import box_corners, set_up
from kinolab.show.page.content import Content


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

    @property
    def reach(self) -> float:
        """How far the machine reaches from the middle of its bodies, in [m]."""
        return self.still.reach


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


def _hull(cloud: Array) -> Array:
    """Return the vertices of the convex hull, or of the bounding box if it is degenerate."""
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
