"""Lines in the picture, as triangles with depth."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from kinolab.numerics.arrays import Array
from kinolab.show.film.raster.rasterizer import NO_FACETS, Facets


def strokes(segments: Array, width: float | Array, color: ArrayLike, lead: float = 0.0) -> Facets:
    """Draw segments as bars with square ends.

    Args:
        segments: End points as column, row and nearness, shape (n, 2, 3); each that is finite gives
            two triangles, which follow each other.
        width: In [pixel]; of each at both ends, shape (n, 2), or of all.
        color: RGB in 0..255; one for all, or one per triangle of segments that are all finite.
        lead: Fraction by which the line is moved toward the viewer, so that an edge is in front of
            its own faces.
    """
    finite = np.isfinite(segments).all(axis=(1, 2))
    half = 0.5 * np.broadcast_to(width, (len(segments), 2))[finite].T[..., None]
    segments = segments[finite]
    if len(segments) == 0:
        return NO_FACETS
    along = segments[:, 1, :2] - segments[:, 0, :2]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    along = np.divide(along, length, out=np.zeros_like(along), where=length > 0.0)
    along[length[:, 0] == 0.0] = (1.0, 0.0)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    nearness = segments[:, :, 2] * (1.0 + lead)
    start, end = segments[:, 0, :2] - half[0] * along, segments[:, 1, :2] + half[1] * along
    left, right = half[0] * normal, half[1] * normal
    places = (start + left, start - left, end - right, end + right)
    a, b, c, d = map(np.column_stack, zip(places, nearness[:, [0, 0, 1, 1]].T, strict=True))
    corners = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3, 3)
    colors = np.broadcast_to(np.asarray(color).astype(np.uint8), (len(corners), 3))
    return Facets(corners, np.ascontiguousarray(colors))


def thinned(line: Array, spacing: float) -> Array:
    """Leave out points of a projected polyline, shape (n, 3), that follow within ``spacing``."""
    if len(line) < 3:
        return line
    run = np.cumsum(np.linalg.norm(np.diff(line[:, :2], axis=0), axis=1))
    keep = np.diff(np.floor(run / spacing), prepend=-1.0) > 0.0
    keep[-1] = True
    return np.asarray(line[np.concatenate([[True], keep])])


def smoothed(points: Array, pieces: int = 4) -> Array:
    """Round the corners of a sampled curve, shape (n, 3), which still passes through its points.

    Source: Catmull and Rom, A Class of Local Interpolating Splines, 1974.
    """
    if len(points) < 3:
        return points
    before = np.concatenate([points[:1], points[:-2]])[:, None]
    after = np.concatenate([points[2:], points[-1:]])[:, None]
    p, q = points[:-1, None], points[1:, None]
    s = (np.arange(pieces) / pieces)[:, None]
    slope_p, slope_q = 0.5 * (q - before), 0.5 * (after - p)
    cubic = slope_p + slope_q + 2.0 * (p - q)
    square = 3.0 * (q - p) - 2.0 * slope_p - slope_q
    curve = p + s * (slope_p + s * (square + s * cubic))
    return np.concatenate([curve.reshape(-1, 3), points[-1:]])


def chain(line: Array) -> Array:
    """The segments of a polyline, shape (n - 1, 2, 3)."""
    return np.stack([line[:-1], line[1:]], axis=1)
