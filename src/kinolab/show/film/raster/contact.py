"""Contact shadows: corners and the feet of things are a little darker, as in soft light.

1 / depth is linear in the picture over a plane; where the mean of two opposite pixels is nearer
than the one between them, the surface is hollow there, and gets less light from the sky.
"""

from __future__ import annotations

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.film.raster.rasterizer import Canvas

REACHES = (2, 7)  # [pixel] of an 800 x 600 picture
DIRECTIONS = ((1, 0), (0, 1), (1, 1), (1, -1))
STRENGTH = 0.42  # how much darker the deepest corner is
HOLLOW = 6e-3  # of 1 / depth: what counts as the deepest corner
AHEAD = 0.03  # of 1 / depth: what is so much nearer stands before it, not beside it
LEAST = 0.03  # darkness that one sees


def darken_corners(canvas: Canvas, scale: int) -> None:
    """Darken hollow places of a canvas of scale x scale small pixels per pixel."""
    middle = scale // 2
    near = canvas.nearness[middle::scale, middle::scale]
    dark = STRENGTH * _hollowness(near.astype(np.float32))
    rows, columns = np.nonzero(dark > LEAST)
    height, width = near.shape
    blocks = canvas.color[: height * scale, : width * scale].reshape(height, scale, width, scale, 3)
    left = (1.0 - dark[rows, columns])[:, None, None, None]
    blocks[rows, :, columns] = (blocks[rows, :, columns] * left + 0.5).astype(np.uint8)


def _hollowness(near: Array) -> Array:
    """How hollow a surface is at each pixel, from 0 to 1, from 1 / depth, shape (h, w)."""
    height, width = near.shape
    most = max(REACHES)
    wide = np.pad(near, most, mode="edge")
    total = np.zeros_like(near)

    def at(dx: int, dy: int) -> Array:
        return wide[most + dy : most + dy + height, most + dx : most + dx + width]

    floor = np.maximum(near, np.float32(1e-12))
    for reach in REACHES:
        for dx, dy in DIRECTIONS:
            a, b = at(reach * dx, reach * dy), at(-reach * dx, -reach * dy)
            bend = (0.5 * (a + b) - near) / floor
            beside = (np.maximum(a, b) < (1.0 + AHEAD) * near) & (np.minimum(a, b) > 0.0)
            total += np.where(beside, np.clip(bend / HOLLOW, 0.0, 1.0), 0.0)
    return np.asarray(np.where(near > 0.0, total / (len(REACHES) * len(DIRECTIONS)), 0.0))
