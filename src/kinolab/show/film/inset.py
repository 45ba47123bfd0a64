"""Inset that enlarges the machine if it is too small to be seen well.

It shows the same view of the same camera at a higher resolution, in an empty corner.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.film.models.assembly import Assembly
from kinolab.show.film.raster.draw_list import Shadows
from kinolab.show.film.raster.rasterizer import Box, Bytes, Facets, average, draw
from kinolab.show.film.raster.shading import Pen
from kinolab.show.film.raster.tiles import Tiles
from kinolab.show.film.scene import machine_facets
from kinolab.show.film.text import label

SUPERSAMPLING = 2  # small pixels per pixel and axis
FRAME = (150, 156, 164)


@dataclass(frozen=True, eq=False)
class Inset:
    """Draws the inset into pictures.

    Args:
        pen: Of the whole picture, enlarged, in small pixels.
        machine: The bodies.
        backdrop: The static backdrop, enlarged.
        box: Position of the inset, in pixels of the picture.
        times: Magnification.
        shadows: Whether there is ground for the machine's shadow.
    """

    pen: Pen
    machine: Assembly
    backdrop: Tiles
    box: Box
    times: float
    shadows: bool

    def put(self, image: Bytes, poses: Array, lines: Array | None) -> None:
        """Draw the inset into a picture, with poses (nb, 12) and cables (nl, 2, 3)."""
        left, top, right, bottom = self.box
        size = ((right - left) * SUPERSAMPLING, (bottom - top) * SUPERSAMPLING)
        column, row = (_middle(self.pen, poses) - np.array(size) / 2).round().astype(int).tolist()
        part = (column, row, column + size[0], row + size[1])
        canvas = self.backdrop.window(part)
        facets, shadows = machine_facets(self.pen, self.machine, poses, lines, self.shadows)
        shift = np.array([column, row, 0.0])
        Shadows([corners - shift for corners in shadows]).on(canvas)
        draw(canvas, Facets(facets.corners - shift, facets.colors))
        seen = average(canvas.color, SUPERSAMPLING)
        label(seen, f"{self.times:.2g}x")
        image[top:bottom, left:right] = FRAME
        image[top + 1 : bottom - 1, left + 1 : right - 1] = seen[1:-1, 1:-1]


def _middle(pen: Pen, poses: Array) -> Array:
    """Column and row of the middle of all bodies' origins."""
    origins = poses.reshape(-1, 12)[:, 3::4]
    return np.asarray(pen.at(origins.mean(axis=0))[:2])
