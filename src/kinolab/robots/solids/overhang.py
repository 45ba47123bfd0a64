"""How far solids stand out of the mesh that they enclose."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.robots.solids.enclosing_solids import enclosing_solids
from kinolab.robots.tree.kinematic_tree import PlacedShape
from kinolab.world.shapes.geometry import triangles as triangles_of


def closest_solids(triangles: Array, within: Array) -> tuple[list[PlacedShape], float]:
    """Return solids around triangles, and how far they stand out: of several tries the least.

    Args:
        triangles: Corners, shape (n, 3, 3), in [m].
        within: Points inside the mesh, shape (m, 3), in [m].
    """
    size = float(np.linalg.norm(np.ptp(triangles.reshape(-1, 3), axis=0)))
    # Paddings that are tried, as shares of it.
    tries = [enclosing_solids(triangles, within, share * size) for share in (0.02, 0.01)]
    found = [(solids, overhang(triangles, within, solids)) for solids in tries]
    return min(found, key=lambda pair: pair[1])


def overhang(triangles: Array, within: Array, solids: Sequence[PlacedShape]) -> float:
    """Return how far solids stand out of triangles at most, in [m], to 2 % of their size or so.

    That is the largest distance from the mesh, inside included, to a point on one solid and in no
    other one.

    Args:
        triangles: Corners, shape (n, 3, 3), in [m].
        within: Points inside the mesh, shape (m, 3), in [m].
    """
    from scipy.spatial import KDTree  # late: only what is enclosed asks

    # 0.01 of points on surfaces, as a share of the mesh's size
    spacing = 0.01 * float(np.linalg.norm(np.ptp(triangles.reshape(-1, 3), axis=0)))
    near = KDTree(np.concatenate([*_points_on(triangles, spacing), within]))
    farthest = 0.0
    for solid in solids:
        vertices, faces = triangles_of(solid.shape)
        points = np.concatenate([*_points_on(vertices[faces], spacing)])
        points = points @ solid.pose[:3, :3].T + solid.pose[:3, 3]
        for other in solids:
            if other is not solid:
                own = (points - other.pose[:3, 3]) @ other.pose[:3, :3]
                points = points[other.shape.depths(own) < -spacing]
        if len(points):
            farthest = max(farthest, float(near.query(points)[0].max()))
    return farthest


def _points_on(triangles: Array, spacing: float) -> Iterator[Array]:
    """Yield points (m, 3) on triangles (n, 3, 3), about so far from each other."""
    edges = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
    across = np.clip(np.ceil(edges / spacing), 1, 50).astype(int)  # points along an edge
    for count in np.unique(across):
        i, j = (part.reshape(-1) for part in np.mgrid[: count + 1, : count + 1])
        first, second = (part[i + j <= count] / count for part in (i, j))
        weights = np.stack([first, second, 1.0 - first - second], axis=1)
        yield (weights @ triangles[across == count]).reshape(-1, 3)
