"""The axes of frames: three strokes from each origin, before everything, and the frame's name."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from kinolab.numerics.arrays import Array, Bytes
from kinolab.show.film.models.surface_mesh import SurfaceMesh
from kinolab.show.film.raster.rasterizer import Box, Facets
from kinolab.show.film.raster.shading import Pen
from kinolab.show.film.raster.stroke import strokes
from kinolab.show.film.text import Words, caption_size, name_tag

X, Y, Z = (213, 94, 0), (0, 158, 115), (0, 114, 178)  # as on the page; told apart by all eyes
WIDTH = 1.8  # [pixel]
WHITE, AROUND = (255, 255, 255), 0.8  # [pixel]: bodies may have the colour of an axis
AROUND_LEAD, LEAD = (
    0.98,
    1.0,
)  # of 1 / depth: bodies that are less than twice as near as an axis do not hide it
LENGTH = 0.4  # of axes, in geometric means of the sizes of a machine and its world
LEAST = 1e-3  # [m] of a machine's reach: one without shapes has none
LINES = 4  # of names under each other, where several frames have the same origin


def reach_of(machine: Sequence[SurfaceMesh], motion: Array) -> float:
    """How far a machine reaches from the middle of its bodies on a motion (nt, nb, 12), in [m]."""
    if not machine:
        return LEAST
    origins = motion[..., 3::4]
    away = np.linalg.norm(origins - origins.mean(axis=1, keepdims=True), axis=-1).max(axis=0)
    sizes = [np.linalg.norm(mesh.vertices, axis=1).max(initial=0.0) for mesh in machine]
    return float(max(np.max(away + np.array(sizes), initial=0.0), LEAST))


def axis_length(reach: float, size: float, frames: int) -> float:
    """Return how long axes are in [m], between a machine and its world; those of many are shorter.

    Args:
        reach: Of the machine from its middle, in [m].
        size: Of all that is seen, in [m].
        frames: How many there are: the axes of all of them cover the same part of a picture.
    """
    return LENGTH * math.sqrt(reach * size / max(frames, 1))


def axes_of(poses: Array, length: float) -> Array:
    """Return x, y and z axes of frames at poses (..., 12) as segments, shape (n, 3, 2, 3)."""
    g = poses.reshape(-1, 3, 4).swapaxes(1, 2)  # rows: the axes, then the origin
    origins = np.repeat(g[:, 3:], 3, axis=1)
    return np.stack([origins, origins + length * g[:, :3]], axis=2)


def axes_at(pen: Pen, poses: Array, length: float) -> Facets:
    """Draw the axes of frames at poses, shape (n, 12)."""
    segments = pen.at(axes_of(poses, length).reshape(-1, 2, 3))
    seen = np.isfinite(segments).all(axis=(1, 2))
    colors = np.repeat(np.tile([X, Y, Z], (len(poses), 1))[seen], 2, axis=0)  # two triangles each
    around = strokes(segments[seen], (WIDTH + 2 * AROUND) * pen.scale, WHITE, AROUND_LEAD)
    return around + strokes(segments[seen], WIDTH * pen.scale, colors, LEAD)


def put_names(
    image: Bytes,
    names: Sequence[str],
    places: Array,
    colors: tuple[tuple[int, int, int], tuple[int, int, int]],
) -> None:
    """Write names under points of an image; none covers another one.

    Args:
        image: RGB pixels, shape (h, w, 3).
        names: One per point.
        places: Column, row and nearness of the points, shape (n, 3), in [pixel].
        colors: Of letters, and of what is around them.
    """
    line, taken = caption_size(len(image)) + 3, list[Box]()
    for name, (column, row, near) in zip(names, places, strict=True):
        for k in range(LINES) if near > 0.0 else ():
            tag = [part.moved(column, row + (k + 1) * line) for part in name_tag(name, len(image))]
            if not _inside(tag[1], image):
                break
            if not any(_meet(tag[0].box, other) for other in taken):
                taken.append(tag[0].box)
                for words, color in zip(tag[::-1], colors[::-1], strict=True):
                    words.on(image, color)
                break


def _inside(words: Words, image: Bytes) -> bool:
    left, top, right, bottom = words.box
    return min(left, top) >= 0 and right <= image.shape[1] and bottom <= image.shape[0]


def _meet(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
