"""Inset that enlarges the machine if it is too small to be seen well.

It shows the same view of the same camera at a higher resolution, in an empty corner.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.film.models.assembly import Assembly
from kinolab.show.film.raster.draw_list import Shadows
from kinolab.show.film.raster.rasterizer import Box, Bytes, Facets, average
from kinolab.show.film.raster.shading import Pen
from kinolab.show.film.raster.tiles import Tiles
from kinolab.show.film.scene import machine_facets, put_machine
from kinolab.show.film.staging.backdrop import Still
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
        still: What stands still.
        framed: Whether it is a part of a picture, with a frame, and not a picture by itself.
    """

    pen: Pen
    machine: Assembly
    backdrop: Tiles
    box: Box
    times: float
    still: Still
    framed: bool = True

    def views(self, poses: Array, lines: Array | None) -> Iterator[Bytes]:
        """Draw the insets of frames, with poses (nf, nb, 12) and cables (nf, nl, 2, 3)."""
        left, top, right, bottom = self.box
        size = ((right - left) * SUPERSAMPLING, (bottom - top) * SUPERSAMPLING)
        corners = (_middles(self.pen, poses) - np.array(size) / 2).round().astype(int).tolist()
        machine = machine_facets(self.pen, self.machine, poses, lines, self.still.floor is not None)
        for corner, (facets, shadows) in zip(corners, machine, strict=True):
            yield self._view(corner, size, facets, shadows)

    def _view(
        self, corner: tuple[int, int], size: tuple[int, int], facets: Facets, shadows: list[Array]
    ) -> Bytes:
        """The inset with its frame, for the window at a corner (column, row) of the large picture.

        Sizes are in small pixels.
        """
        (column, row), (width, height) = corner, size
        canvas = self.backdrop.window((column, row, column + width, row + height))
        shift = np.array([column, row, 0.0])
        Shadows([corners - shift for corners in shadows]).on(canvas)
        put_machine(canvas, Facets(facets.corners - shift, facets.colors), self.still)
        seen = average(canvas.color, SUPERSAMPLING)
        if not self.framed:
            return seen
        label(seen, f"{self.times:.2g}x")
        seen[0], seen[-1], seen[:, 0], seen[:, -1] = FRAME, FRAME, FRAME, FRAME
        return seen

    def put(self, view: Bytes, image: Bytes) -> None:
        """Put an inset into its picture."""
        left, top, right, bottom = self.box
        image[top:bottom, left:right] = view


def _middles(pen: Pen, poses: Array) -> Array:
    """Column and row of the middle of all bodies' origins, shape (nf, 2), at poses (nf, nb, 12)."""
    origins = poses[..., 3::4]
    return np.asarray(pen.at(origins.mean(axis=1, keepdims=True))[:, 0, :2])
