"""The axes of frames: three strokes from each origin, before everything, and the frame's name."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinolab.numerics.arrays import Array, Bytes
from kinolab.show.film.raster.rasterizer import Box, Facets
from kinolab.show.film.raster.shading import Pen
from kinolab.show.film.raster.stroke import strokes
from kinolab.show.film.staging.text import Words, caption_size, name_tag
from kinolab.show.scene.frame_axes import axes_of

X, Y, Z = (213, 94, 0), (0, 158, 115), (0, 114, 178)  # as on the page; told apart by all eyes
WIDTH = 1.8  # [pixel]
WHITE, AROUND = (255, 255, 255), 0.8  # [pixel]: bodies may have the colour of an axis
AROUND_LEAD, LEAD = (
    0.98,
    1.0,
)  # of 1 / depth: bodies that are less than twice as near as an axis do not hide it


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
        # 4 lines of names under each other, where several frames have the same origin
        for k in range(4) if near > 0.0 else ():
            tag = [part.moved(column, row + (k + 1) * line) for part in name_tag(name, len(image))]
            if not _inside(tag[1], image):
                break
            if not any(tag[0].meets(other) for other in taken):
                taken.append(tag[0].box)
                for words, color in zip(tag[::-1], colors[::-1], strict=True):
                    words.on(image, color)
                break


def _inside(words: Words, image: Bytes) -> bool:
    left, top, right, bottom = words.box
    return min(left, top) >= 0 and right <= image.shape[1] and bottom <= image.shape[0]
