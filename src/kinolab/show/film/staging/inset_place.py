"""Where an inset goes, and what it shows: an empty corner, the machine enlarged."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.film.raster.rasterizer import Box
from kinolab.show.film.raster.shading import Pen
from kinolab.show.film.raster.tiles import Tiles
from kinolab.show.film.staging.assembly import Assembly
from kinolab.show.film.staging.backdrop import backdrop
from kinolab.show.film.staging.inset import SUPERSAMPLING, Inset
from kinolab.show.film.staging.script import Script
from kinolab.show.film.staging.stage import PAPER, Stage
from kinolab.show.film.staging.text import heading
from kinolab.show.scene.still import paths_of

LEAST_MAGNIFICATION, MAX_MAGNIFICATION = 1.2, 12.0  # times; of a picture by itself, of any


def build_inset(stage: Stage, script: Script) -> Inset | None:
    """Return the inset of a film; None if the machine is large enough, or no corner is free."""
    paths = paths_of(stage.machine.bodies, script.poses)
    places, apparent = _apparent(stage, script, paths)
    # 0.07 of the picture's height: larger machines need no inset
    if not 0.0 < apparent < 0.07 * script.size[1]:
        return None
    scale = stage.pen.scale
    nearness = stage.canvas.nearness[scale // 2 :: scale, scale // 2 :: scale]
    box = next(_free_corners(nearness > 0.0, places.reshape(-1, 2)), None)
    if box is None:
        return None
    # 0.45 of the inset's height that the machine takes
    times = min(0.45 * (box[3] - box[1]) / apparent, MAX_MAGNIFICATION)
    return _enlarged(stage, script, paths, box, times)


def whole_window(stage: Stage, script: Script) -> Inset | None:
    """Return a window as large as the picture that goes with the machine; None if it is large."""
    paths = paths_of(stage.machine.bodies, script.poses)
    (_, apparent), tall = _apparent(stage, script, paths), script.size[1]
    # 0.3 of a whole picture's height that the machine takes that it goes with
    times = min(0.3 * tall / apparent, MAX_MAGNIFICATION) if apparent > 0.0 else 1.0
    if times <= LEAST_MAGNIFICATION:
        return None
    return replace(_enlarged(stage, script, paths, (0, 0, *script.size), times), framed=False)


def _apparent(stage: Stage, script: Script, paths: Sequence[Array]) -> tuple[Array, float]:
    """Where the corners of the bodies' boxes are in the picture, and the machine's usual size."""
    if not paths:
        return np.zeros((0, 0, 2)), 0.0
    places = np.concatenate(
        [stage.pen.camera.project(path, script.size)[..., :2] for path in paths], axis=1
    )
    return places, float(np.median(np.ptp(places, axis=1).max(axis=1)))


def _enlarged(
    stage: Stage, script: Script, paths: Sequence[Array], box: Box, times: float
) -> Inset:
    """The machine and what is around it, so many times as large."""
    camera, picture = stage.pen.camera, stage.still.picture
    wide, tall = script.size
    large = (round(wide * times * SUPERSAMPLING), round(tall * times * SUPERSAMPLING))
    pen = Pen(camera, large, stage.pen.light, SUPERSAMPLING)
    machine = picture.machine(SUPERSAMPLING * camera.nearest_pixel(paths, large))
    layers = backdrop(stage.still, machine, pen)
    assembly = Assembly(machine, picture.radii)
    return Inset(pen, assembly, Tiles(layers, PAPER), box, times, stage.still)


def _free_corners(taken: NDArray[np.bool_], places: Array) -> Iterator[Box]:
    """Yield nearly empty corners of the picture, the largest and emptiest first.

    Args:
        taken: The pixels at which there is more than sky, shape (h, w).
        places: Columns and rows that the machine will cover, shape (n, 2).
    """
    height, width = taken.shape
    # 0.02 of the picture's height: distance from the edge
    edge, under = round(0.02 * height), heading(height)
    for fraction in (0.36, 0.3, 0.25):  # of the picture's height; the first that fits is taken
        tall = round(fraction * height)
        wide = round((4 / 3) * tall)  # width for a height of one
        lefts, tops = (edge, width - edge - wide), (under, height - edge - tall)
        boxes = [(x, y, x + wide, y + tall) for y in tops for x in lefts]
        empty = sorted((float(taken[y:b, x:r].mean()), (x, y, r, b)) for x, y, r, b in boxes)
        for shown, (x, y, r, b) in empty:
            low, high = (x, y), (r, b)
            # 0.02: fraction of a corner that may be occupied
            if shown <= 0.02 and not ((places > low) & (places < high)).all(axis=1).any():
                yield x, y, r, b
