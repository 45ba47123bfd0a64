"""Inset that enlarges the machine if it is too small to be seen well.

It shows the same view of the same camera at a higher resolution, in an empty corner.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array, Bytes
from kinolab.show.film.raster.rasterizer import Box, average
from kinolab.show.film.raster.shading import Pen
from kinolab.show.film.raster.tiles import Tiles
from kinolab.show.film.staging.assembly import Assembly
from kinolab.show.film.staging.stage import machine_facets, name_frames, put_machine
from kinolab.show.film.staging.text import label
from kinolab.show.scene.still import Still

SUPERSAMPLING = 2  # small pixels per pixel and axis
FRAME = (150, 156, 164)


@dataclass(frozen=True, eq=False)
class Inset:
    """Draws the inset into pictures.

    Args:
        pen: Of the whole picture, enlarged, in small pixels.
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

    def views(
        self, poses: Array, lines: Array | None, axes: Array | None = None
    ) -> Iterator[Bytes]:
        """Draw the insets of frames, with poses (nf, nb, 12) and cables (nf, nl, 2, 3).

        Axes of frames at poses (nf, n, 12) have names only in a picture by itself.
        """
        left, top, right, bottom = self.box
        size = ((right - left) * SUPERSAMPLING, (bottom - top) * SUPERSAMPLING)
        middles = self.pen.at(poses[..., 3::4].mean(axis=1, keepdims=True))[:, 0, :2]
        corners = (middles - np.array(size) / 2).round().astype(int).tolist()
        machine = machine_facets(self.pen, self.machine, poses, lines, self.still, axes)
        for k, (corner, (facets, shadows)) in enumerate(zip(corners, machine, strict=True)):
            column, row = corner  # of a window of the large picture, in small pixels
            canvas = self.backdrop.window((column, row, column + size[0], row + size[1]))
            put_machine(canvas, (column, row), facets, shadows, self.still)
            seen = average(canvas.color, SUPERSAMPLING)
            if self.framed:
                label(seen, f"{self.times:.2g}x")
                seen[0], seen[-1], seen[:, 0], seen[:, -1] = FRAME, FRAME, FRAME, FRAME
            elif axes is not None:
                name_frames(seen, self.still, self.pen, axes[k], (column, row))
            yield seen
