"""Solids around the convex parts of a mesh: several fit it closer than one around the whole.

CoACD divides a mesh where it is not convex; parts are then cut across, as long as the solids around
the halves are clearly smaller. Every triangle of the mesh is inside one of the solids as a whole or
in pieces, so that they are never too small.

Source: Wei, Liu, Ling, Su, Approximate convex decomposition for 3D meshes with collision-aware
concavity and tree search, ACM Transactions on Graphics 41(4), 2022.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kinolab.concurrency.stages import doing
from kinolab.errors import InputError, Mistake
from kinolab.lazy import library_of
from kinolab.numerics.arrays import Array
from kinolab.robots.solids.enclosing import enclosing_shape, volume
from kinolab.robots.tree.kinematic_tree import PlacedShape
from kinolab.scenario.values import MOST_PARTS
from kinolab.store import Kind, pack_arrays, unpack_arrays
from kinolab.world.shapes.shape_surfaces import Faces

EFFORT = {  # of CoACD's tree search, a third of its own, which takes minutes
    **{"mcts_nodes": 10, "mcts_iterations": 60, "mcts_max_depth": 2},
    **{"resolution": 1000, "preprocess_resolution": 30},
}
BATCH = 20_000  # points at once


def enclosing_shapes(
    vertices: Array, faces: Faces, most: int | None, where: str
) -> list[PlacedShape]:
    """Return solids that contain all triangles of a mesh.

    Args:
        vertices, faces: Of the mesh, shapes (n, 3) in [m] and (m, 3).
        most: Parts into which it may be divided; None for one solid around the whole.
        where: What mistakes are reported for.

    Raises:
        InputError: If CoACD is not installed, or the mesh has too many triangles.
    """
    if most is None or most == 1:
        return [enclosing_shape(vertices)]
    return [enclosing_shape(points) for points in _kept_parts(vertices, faces, most, where)]


def check_parts(convex_parts: int | None, where: str) -> None:
    """Raise unless a number of parts is one that a mesh may be divided into.

    Raises:
        InputError: If it is not.
    """
    if convex_parts is None:
        return
    if type(convex_parts) is not int or not 1 <= convex_parts <= MOST_PARTS:
        what = f"it is {convex_parts!r}."
        remedy = f"Give a whole number from 1 to {MOST_PARTS}."
        raise InputError([Mistake(f"{where} convex_parts".strip(), what, remedy)])
    library_of("convex", "coacd", "meshes are divided by CoACD")


def _kept_parts(vertices: Array, faces: Faces, most: int, where: str) -> list[Array]:
    """Return points (n, 3) around each part, from disk where they are there."""
    if len(faces) > 100_000:  # which takes minutes
        what = f"it has {len(faces)} triangles, of which at most 100000 can be divided."
        raise InputError([Mistake(where, what, "Simplify it, or leave convex_parts out.")])
    points = np.ascontiguousarray(vertices, dtype=np.float64)
    corners = np.ascontiguousarray(faces, dtype=np.int64)
    content = str(most), version("coacd"), points.tobytes(), corners.tobytes()
    return PARTS.get(content, lambda: _parts(points, corners, most, where))


def _pack(parts: list[Array]) -> bytes:
    return pack_arrays((np.array([*map(len, parts)]), np.vstack(parts)))


def _unpack(content: memoryview) -> list[Array]:
    sizes, points = unpack_arrays(content, np.int64, np.float64)
    return np.split(points, np.cumsum(sizes)[:-1])


PARTS = Kind("parts", _pack, _unpack, (Path(__file__).parent,), most=2**26)


def _parts(vertices: Array, faces: Faces, most: int, where: str) -> list[Array]:
    if len(faces) > 5_000:  # triangles that are divided in half a minute or so
        told = "%s: dividing %d triangles into convex parts, once; it may take a minute."
        logging.getLogger("kinolab").warning(told, where, len(faces))
    doing(f"dividing {where} into convex parts")
    hulls = _decomposed(vertices, faces, most)
    pieces = _pieces(vertices[faces])
    nearest = _nearest(pieces.mean(axis=1), hulls)
    parts = [
        _corners(np.vstack([hull, pieces[nearest == k].reshape(-1, 3)]))
        for k, hull in enumerate(hulls)
    ]
    return _cut(parts, most)


def _decomposed(vertices: Array, faces: Faces, most: int) -> list[Array]:
    """Return the corners (n, 3) of convex parts, by CoACD."""
    library = library_of("convex", "coacd", "meshes are divided by CoACD")
    library.set_log_level("error")
    mesh = library.Mesh(vertices, faces.astype(np.int32))
    # 0.05 of CoACD: a part's largest distance from its hull, as a share of its size
    found = library.run_coacd(mesh, 0.05, max_convex_hull=most, seed=0, **EFFORT)
    hulls = [np.asarray(points, dtype=float).reshape(-1, 3) for points, _ in found]
    return [hull for hull in hulls if len(hull)] or [vertices]


def _pieces(triangles: Array) -> Array:
    """Return triangles (m, 3, 3), the long ones divided into four, again and again."""
    # Pieces of triangles are shorter than a 16th of the mesh's size.
    longest = float(np.ptp(triangles.reshape(-1, 3), axis=0).max()) / 16
    done: list[Array] = []
    while len(triangles):
        edges = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).max(axis=1)
        long = edges > longest
        if 4 * int(long.sum()) > 500_000:
            break
        done.append(triangles[~long])
        (a, b, c) = np.moveaxis(triangles[long], 1, 0)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        quarters = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        triangles = np.concatenate([np.stack(corners, axis=1) for corners in quarters])
    return np.concatenate([*done, triangles])


def _nearest(points: Array, hulls: Sequence[Array]) -> Array:
    """Return for points (n, 3) which hull each is deepest in, or least outside of."""
    if len(hulls) == 1:
        return np.zeros(len(points), dtype=int)
    outside = np.empty((len(hulls), len(points)))
    for k, hull in enumerate(hulls):
        planes = ConvexHull(hull, qhull_options="QJ").equations
        for first in range(0, len(points), BATCH):
            batch = slice(first, first + BATCH)
            outside[k, batch] = (points[batch] @ planes[:, :3].T + planes[:, 3]).max(axis=1)
    nearest: Array = outside.argmin(axis=0)
    return nearest


def _corners(points: Array) -> Array:
    """Return those of points (n, 3) that are corners of their convex hull."""
    try:
        corners: Array = points[ConvexHull(points).vertices]
    except QhullError:  # they are in a plane
        return points
    return corners


@dataclass(frozen=True)
class _Cut:
    gain: float
    part: int
    halves: tuple[Array, Array]


def _cut(parts: list[Array], most: int) -> list[Array]:
    """Cut parts in two where that makes the solids around them clearly smaller."""
    cuts = [_best_cut(k, points) for k, points in enumerate(parts)]
    while len(parts) < most:
        # 0.03 of the volume of all solids, by which a cut must reduce it
        enough = 0.03 * sum(volume(enclosing_shape(points)) for points in parts)
        best = max(cuts, key=lambda cut: cut.gain)
        if best.gain < enough:
            break
        for k, half in zip((best.part, len(parts)), best.halves, strict=True):
            parts[k : k + 1] = [half]
            cuts[k : k + 1] = [_best_cut(k, half)]
    return parts


def _best_cut(part: int, points: Array) -> _Cut:
    """Return the cut of a part's points (n, 3) after which the solids are smallest."""
    whole = enclosing_shape(points)
    best = _Cut(0.0, part, (points, points))
    try:
        faces = ConvexHull(points).simplices
    except QhullError:
        return best  # it is flat
    edges = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    for axis in whole.pose[:3, :3].T:
        along = points @ axis
        low, high = along.min(), along.max()
        for share in (0.25, 0.5, 0.75):  # where a part is tried to be cut, along its solid's axes
            height = along - (low + share * (high - low))
            halves = _halves(points, edges, height)
            gain = volume(whole) - sum(volume(enclosing_shape(half)) for half in halves)
            if gain > best.gain:
                best = _Cut(gain, part, halves)
    return best


def _halves(points: Array, edges: Array, height: Array) -> tuple[Array, Array]:
    """Return points around what is above and below a plane, of a hull with edges (m, 2)."""
    a, b = edges[height[edges[:, 0]] * height[edges[:, 1]] < 0.0].T
    share = (height[a] / (height[a] - height[b]))[:, None]
    between = points[a] + share * (points[b] - points[a])
    above, below = points[height >= 0.0], points[height <= 0.0]
    return np.vstack([above, between]), np.vstack([below, between])
