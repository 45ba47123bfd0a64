"""Inset that enlarges the machine if it is too small to be seen well.

It shows the same view of the same camera at a higher resolution, in an empty corner.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.film.backdrop import PAPER, backdrop
from kinolab.show.film.models.paint import paint_machine
from kinolab.show.film.models.surface_mesh import SurfaceMesh
from kinolab.show.film.picture import Picture
from kinolab.show.film.raster.draw_list import Layer, Shadows, drawn
from kinolab.show.film.raster.rasterizer import Box, Bytes, Facets, average, draw
from kinolab.show.film.raster.shading import Pen
from kinolab.show.film.scene import Scene, machine_facets, nearest_pixel, swept
from kinolab.show.film.text import heading, label

SMALL_FRACTION = 0.055  # of the picture's height: larger machines need no inset
FILL_FRACTION = 0.45  # of the inset's height that the machine takes
MAX_MAGNIFICATION = 12.0  # times
SIZES = (0.36, 0.3, 0.25)  # of the picture's height; the first that fits is taken
ASPECT_RATIO = 4 / 3  # width for a height of one
EDGE_MARGIN = 0.02  # of the picture's height: distance from the edge
MAX_COVERED = 0.02  # fraction of a corner that may be occupied
SUPERSAMPLING = 2  # small pixels per pixel and axis
FRAME = (150, 156, 164)


@dataclass(frozen=True, eq=False)
class Inset:
    """Draws the inset into pictures.

    Args:
        pen: Of the whole picture, enlarged, in small pixels.
        machine: One mesh per body, in the body's frame.
        layers: The static backdrop.
        box: Position of the inset, in pixels of the picture.
        times: Magnification.
        shadows: Whether there is ground for the machine's shadow.
    """

    pen: Pen
    machine: tuple[SurfaceMesh, ...]
    layers: Sequence[Layer]
    box: Box
    times: float
    shadows: bool

    def put(self, image: Bytes, poses: Array, lines: Array | None) -> None:
        """Draw the inset into a picture, with poses (nb, 12) and cables (nl, 2, 3)."""
        left, top, right, bottom = self.box
        size = ((right - left) * SUPERSAMPLING, (bottom - top) * SUPERSAMPLING)
        column, row = (_middle(self.pen, poses) - np.array(size) / 2).round().astype(int).tolist()
        part = (column, row, column + size[0], row + size[1])
        canvas = drawn([layer.within(part) for layer in self.layers], size, PAPER)
        facets, shadows = machine_facets(self.pen, self.machine, poses, lines, self.shadows)
        shift = np.array([column, row, 0.0])
        Shadows([corners - shift for corners in shadows]).on(canvas)
        draw(canvas, Facets(facets.corners - shift, facets.colors))
        seen = label(average(canvas.color, SUPERSAMPLING), f"{self.times:.2g}x")
        image[top:bottom, left:right] = FRAME
        image[top + 1 : bottom - 1, left + 1 : right - 1] = seen[1:-1, 1:-1]


def build_inset(
    picture: Picture, stage: Scene, motion: Array, size: tuple[int, int]
) -> Inset | None:
    """Return the inset; None if the machine is large enough, or no corner is free.

    Args:
        picture: The picture to draw.
        stage: The scene of the picture.
        motion: Poses of all frames, shape (nf, nb, 12).
        size: Width and height of the picture in [pixel].
    """
    camera, height = stage.pen.camera, size[1]
    paths = [swept(mesh, motion[:, i]) for i, mesh in enumerate(stage.machine) if len(mesh.faces)]
    if not paths:
        return None
    places = np.concatenate([camera.project(path, size)[..., :2] for path in paths], axis=1)
    apparent = float(np.median(np.ptp(places, axis=1).max(axis=1)))
    if not 0.0 < apparent < SMALL_FRACTION * height:
        return None
    box = next(_free_corners(stage.image, places.reshape(-1, 2)), None)
    if box is None:
        return None
    times = min(FILL_FRACTION * (box[3] - box[1]) / apparent, MAX_MAGNIFICATION)
    large = (round(size[0] * times * SUPERSAMPLING), round(height * times * SUPERSAMPLING))
    pen = Pen(camera, large, stage.pen.light, SUPERSAMPLING)
    pixel = nearest_pixel(camera, stage.machine, motion, large)
    machine = paint_machine(picture.bodies, SUPERSAMPLING * pixel)
    layers = backdrop(picture, machine, pen, stage.floor)
    return Inset(pen, machine, layers, box, times, stage.floor is not None)


def _middle(pen: Pen, poses: Array) -> Array:
    """Column and row of the middle of all bodies' origins."""
    origins = poses.reshape(-1, 12)[:, 3::4]
    return np.asarray(pen.at(origins.mean(axis=0))[:2])


def _free_corners(image: Bytes, places: Array) -> Iterator[Box]:
    """Yield nearly empty corners of the picture, the largest and emptiest first.

    Args:
        image: The backdrop, shape (h, w, 3).
        places: Columns and rows that the machine will cover, shape (n, 2).
    """
    height, width = image.shape[:2]
    taken = (image != np.array(PAPER, dtype=np.uint8)).any(axis=-1)
    edge, under = round(EDGE_MARGIN * height), heading(height)
    for fraction in SIZES:
        tall = round(fraction * height)
        wide = round(ASPECT_RATIO * tall)
        lefts, tops = (edge, width - edge - wide), (under, height - edge - tall)
        boxes = [(x, y, x + wide, y + tall) for y in tops for x in lefts]
        empty = sorted((float(taken[y:b, x:r].mean()), (x, y, r, b)) for x, y, r, b in boxes)
        for shown, (x, y, r, b) in empty:
            low, high = (x, y), (r, b)
            if shown <= MAX_COVERED and not ((places > low) & (places < high)).all(axis=1).any():
                yield x, y, r, b
