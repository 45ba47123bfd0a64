"""Surfaces that are cut open, like a model of a house without its roof."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.scene.models.surface_mesh import Indices, SurfaceMesh, is_room, join, weld

SPACING = 48  # points along each side of the ground around a room
CHUNK = 2000  # points of which one asks at once whether they are inside

Heights: TypeAlias = Callable[[Array], Array]  # of points (n, 2) on the map, in [m]


def level(height: float) -> Heights:
    """The same height everywhere."""
    return lambda points: np.full(len(points), height)


def along(way: Array) -> Heights:
    """The height of a way of points (n, 3) where it passes, and between its parts a mean."""
    count = min(len(way), SPACING)
    places = way[np.linspace(0, len(way) - 1, count).astype(int)]
    size = max(float(np.ptp(places[:, :2], axis=0).max()), 1e-9)

    def height(points: Array) -> Array:
        found = np.empty(len(points))
        for first in range(0, len(points), CHUNK):
            part = slice(first, first + CHUNK)
            x, y = points[part, :1] - places[:, 0], points[part, 1:] - places[:, 1]
            # 1e-4 of the way's size squared: nearer parts of a way count alike
            away = (x * x + y * y) / size**2 + 1e-4
            weight = 1.0 / (away * away)
            found[part] = weight @ places[:, 2] / weight.sum(axis=1)
        return found

    return height


def cut_open(mesh: SurfaceMesh, heights: Heights) -> SurfaceMesh:
    """Leave out what is above some heights, and close the cut.

    What is solid shows its inside there; around a room the ground is drawn in which it lies.
    """
    vertices = mesh.vertices
    above = vertices[:, 2] - heights(vertices[:, :2])
    if not len(mesh.faces) or above.max() <= 0.0:
        return mesh
    below, ends = _clipped(mesh, above)
    if not len(ends):
        return below
    room, color = is_room(mesh), 0.93 * mesh.colors[0]  # of the first colour: how bright the cut is
    # 2e-3 of a solid's size: how far its cut lies above the ground around a room
    lift = 0.0 if room else 2e-3 * float(np.ptp(ends, axis=0).max())
    parts = [below, _lid(ends, lambda places: heights(places) + lift, room, color)]
    if room:
        parts.append(_skirt(ends, float(vertices[:, 2].min()), heights, color))
    return join(parts)


def _clipped(mesh: SurfaceMesh, above: Array) -> tuple[SurfaceMesh, Array]:
    """The part of a surface where a number per vertex is not positive; faces across are cut.

    Returns:
        The part, and where it is cut: segments on the map, shape (n, 2, 2), in [m].
    """
    corners, colors = np.column_stack([mesh.vertices, above])[mesh.faces], mesh.colors
    count = (corners[..., 3] <= 0.0).sum(axis=1)
    kept, kept_colors, ends = [corners[count == 3]], [colors[count == 3]], []
    for low in (1, 2):
        part = _turned(corners[count == low], alone_below=low == 1)
        a, b, c = part[:, 0], part[:, 1], part[:, 2]
        p, q = _between(a, b), _between(a, c)
        ends.append(np.stack([p[:, :2], q[:, :2]], axis=1))
        if low == 1:
            kept.append(np.stack([a, p, q], axis=1))
            kept_colors.append(colors[count == 1])
        else:
            kept += [np.stack([p, b, c], axis=1), np.stack([p, c, q], axis=1)]
            kept_colors += [colors[count == 2]] * 2
    points = np.concatenate(kept)[..., :3]
    faces = np.arange(3 * len(points)).reshape(-1, 3)
    below = weld(points.reshape(-1, 3), faces, np.concatenate(kept_colors))
    return below, np.concatenate(ends)


def _turned(corners: Array, *, alone_below: bool) -> Array:
    """Faces (m, 3, 4) whose first corner is the one that is alone on its side of the cut."""
    alone = (corners[..., 3] <= 0.0) == alone_below
    first = np.argmax(alone, axis=1)
    order = (first[:, None] + np.arange(3)) % 3
    return np.asarray(np.take_along_axis(corners, order[..., None], axis=1))


def _between(a: Array, b: Array) -> Array:
    fraction = -a[:, 3:] / (b[:, 3:] - a[:, 3:])
    return np.asarray(a + fraction * (b - a))


def _lid(ends: Array, heights: Heights, room: bool, color: Array) -> SurfaceMesh:
    """The surface at a cut: inside its outline, or around it in a rectangle."""
    from scipy.spatial import Delaunay, cKDTree  # late: few pictures are cut

    step = float(np.max(np.ptp(ends, axis=(0, 1)))) / SPACING
    # Points along segments, at most a step apart: triangles then keep to the outline.
    length = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max())
    steps = np.linspace(0.0, 1.0, 2 + min(int(length / max(step, 1e-12)), SPACING))[:, None, None]
    points = np.asarray((ends[:, 0] + steps * (ends[:, 1] - ends[:, 0])).reshape(-1, 2))
    if room:
        low, high = _rim(ends)
        steps = np.linspace(0.0, 1.0, SPACING)
        grid = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        places = low + grid * (high - low)
        apart, _ = cKDTree(points).query(places)  # edges of triangles then follow the outline
        points = np.concatenate([points, places[apart > step]])
    points = np.unique(points.round(6), axis=0)
    faces = Delaunay(points).simplices.astype(np.int64)
    inside = _inside(points[faces].mean(axis=1), ends)
    chosen: Indices = faces[inside != room]
    a, b, c = (points[chosen[:, k]] for k in range(3))
    turned = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0] < 0.0
    chosen[turned] = chosen[turned][:, ::-1]
    return weld(np.column_stack([points, heights(points)]), chosen, color)


def _rim(ends: Array) -> tuple[Array, Array]:
    """The rectangle of ground around a room, by two opposite corners (2,)."""
    low, high = ends.min(axis=(0, 1)), ends.max(axis=(0, 1))
    # 0.06 of the longer side: how far the ground around a room reaches beyond it
    margin = 0.06 * float(np.max(high - low))
    return low - margin, high + margin


def _skirt(ends: Array, bottom: float, heights: Heights, color: Array) -> SurfaceMesh:
    """The sides of the block of ground that a room lies in."""
    (x0, y0), (x1, y1) = _rim(ends)
    corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)])
    steps = np.linspace(0.0, 1.0, SPACING)[:-1, None]
    ring = np.concatenate([a + steps * (b - a) for a, b in pairwise(corners)])
    n = len(ring)
    points = np.concatenate(
        [np.column_stack([ring, z]) for z in (np.full(n, bottom), heights(ring))]
    )
    a = np.arange(n)
    b = (a + 1) % n
    faces = [np.stack([a, b, b + n], axis=1), np.stack([a, b + n, a + n], axis=1)]
    return weld(points, np.concatenate(faces), color)


def _inside(points: Array, ends: Array) -> NDArray[np.bool_]:
    """Whether points (n, 2) are inside closed outlines given as segments, by the even-odd rule."""
    a, b = ends[:, 0], ends[:, 1]
    slope = (b[:, 0] - a[:, 0]) / np.where(b[:, 1] == a[:, 1], 1.0, b[:, 1] - a[:, 1])
    found = np.zeros(len(points), dtype=bool)
    for first in range(0, len(points), CHUNK):
        x, y = points[first : first + CHUNK, :1], points[first : first + CHUNK, 1:]
        crosses = (a[:, 1] > y) != (b[:, 1] > y)
        right = x < a[:, 0] + (y - a[:, 1]) * slope
        found[first : first + CHUNK] = (crosses & right).sum(axis=1) % 2 == 1
    return found
