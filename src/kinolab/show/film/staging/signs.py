"""Words in the picture: what is what, and how long a metre is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PIL import ImageDraw

from kinolab.numerics.arrays import Array, Bytes
from kinolab.show.film.raster.rasterizer import Box
from kinolab.show.film.staging.text import Words, caption, caption_size, heading
from kinolab.show.scene.camera import Camera
from kinolab.show.scene.captions import captions
from kinolab.show.scene.still import Still

NUMBERS = (5.0, 2.0, 1.0)  # of a scale bar's length, times a power of ten


@dataclass(frozen=True, eq=False)
class Signs:
    """All words of a picture, ready to be written on each frame.

    Args:
        words: The words at their places, with the colours of their letters and of what is around.
    """

    words: tuple[tuple[Words, Words], ...]
    colors: tuple[tuple[int, int, int], tuple[int, int, int]]

    def on(self, image: Bytes) -> None:
        """Write them on an image, shape (h, w, 3)."""
        for inner, outer in self.words:
            outer.on(image, self.colors[1])
            inner.on(image, self.colors[0])


def signs(still: Still, camera: Camera, size: tuple[int, int]) -> Signs:
    """Lay out the words of a picture of width and height in [pixel]; none covers another one."""
    words = []
    taken: list[Box] = [(0, 0, size[0], round(0.85 * heading(size[1])))]
    for each in captions(still):
        column, row, depth = camera.project(each.place, size)
        # Shifts, of the picture's height: where a word goes if it has no room
        for shift in (0.0, 0.05, 0.1, -0.04) if depth > 0.0 else ():
            # 0.012 of the picture's height: how far above its thing a word stands
            foot = float(row) + (shift - 0.012) * size[1]
            made = caption(each.text, (float(column), foot), size)
            if made is not None and not any(made[1].meets(other) for other in taken):
                taken.append(made[1].box)
                words.append(made)
                break
    ruler = _scale_bar(still, camera, size)
    if ruler is not None and not any(ruler[1].meets(other) for other in taken):
        words.append(ruler)
    return Signs(tuple(words), (still.words, still.around))


def _scale_bar(still: Still, camera: Camera, size: tuple[int, int]) -> tuple[Words, Words] | None:
    """A bar along the near edge of the ground, as long as a round number of metres."""
    edge = _near_edge(still, camera, size)
    if edge is None:
        return None
    ends, length = edge
    # 0.22 of the picture's width: the longest scale bar
    step = _round_length(length * 0.22 * size[0] / max(abs(ends[1, 0] - ends[0, 0]), 1.0))
    text = f"{step:g} m"
    first = ends[0, :2]
    last = first + (ends[1, :2] - first) * min(step / length, 1.0)
    letters = caption_size(size[1])

    def bar(pen: ImageDraw.ImageDraw, width: int) -> None:
        below = np.array([0.0, 0.8 * letters])
        a, b = first + below, last + below
        pen.line([tuple(a), tuple(b)], fill=255, width=2 + 2 * width)
        for end in (a, b):
            tick = np.array([0.0, 0.3 * letters + width])
            pen.line([tuple(end - tick), tuple(end + tick)], fill=255, width=2 + 2 * width)

    middle = 0.5 * (first + last)
    return caption(text, (float(middle[0]), float(middle[1]) + 2.6 * letters), size, bar)


def _near_edge(still: Still, camera: Camera, size: tuple[int, int]) -> tuple[Array, float] | None:
    """The edge of the ground that is lowest in the picture, from left to right, and its length."""
    if still.floor is None:
        return None
    (x0, y0), (x1, y1) = still.floor.low, still.floor.high
    corners = np.array([(x0, y0, 0.0), (x1, y0, 0.0), (x1, y1, 0.0), (x0, y1, 0.0)])
    places = camera.project(corners, size)
    if (places[:, 2] <= 0.0).any():
        return None
    edges = [(k, (k + 1) % 4) for k in range(4)]
    across = np.abs(np.diff(places[edges, :2], axis=1)[:, 0])  # columns and rows that they go
    a, b = max(
        (edge for edge, (x, y) in zip(edges, across, strict=True) if x > y),
        key=lambda edge: float(places[list(edge), 1].sum()),
        default=edges[0],
    )
    if places[a, 0] > places[b, 0]:
        a, b = b, a
    return places[[a, b]], float(np.linalg.norm(corners[b] - corners[a]))


def _round_length(length: float) -> float:
    """The largest of 1, 2, 5, 10, … times a power of ten that is no more than a length in [m]."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(next(number * power for number in NUMBERS if number * power <= length * 1.0001))
