"""Layers drawn one after the other on a canvas, whole or clipped to a part of it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.film.raster.light import LIGHT_SAMPLES, SHADOW
from kinolab.show.film.raster.rasterizer import (
    OTHER,
    Box,
    Canvas,
    Facets,
    blank,
    darken,
    draw,
    extent,
    paint_ground,
)

SHADES = 24  # of the sky: a film has 255 colours in all


class Layer(ABC):
    """Something to be drawn over the content of a canvas."""

    @abstractmethod
    def on(self, canvas: Canvas) -> None:
        """Draw the layer."""

    @abstractmethod
    def within(self, box: Box) -> Layer:
        """Return the layer clipped to a box, for a canvas of the box's size."""


@dataclass(frozen=True, eq=False)
class _OfFacets(Layer):
    facets: Facets

    @cached_property
    def _reach(self) -> Array:
        return _reach(self.facets.corners)

    def within(self, box: Box) -> Layer:
        """Return the layer clipped to a box."""
        seen, shift = _seen(self._reach, box)
        corners, colors = self.facets.corners[seen] - shift, self.facets.colors[seen]
        return replace(self, facets=Facets(corners, colors))


@dataclass(frozen=True, eq=False)
class Solid(_OfFacets):
    """Opaque surfaces, with depth test."""

    kind: int = OTHER

    def on(self, canvas: Canvas) -> None:
        """Draw the layer."""
        draw(canvas, self.facets, self.kind)


@dataclass(frozen=True, eq=False)
class FloorPaint(_OfFacets):
    """Colour on the visible floor, drawn without depth test."""

    opacity: float = 1.0

    def on(self, canvas: Canvas) -> None:
        """Draw the layer."""
        if self.opacity == 1.0:
            paint_ground(canvas, self.facets)
        else:
            _mix(canvas, self.facets, self.opacity, paint_ground)


@dataclass(frozen=True, eq=False)
class Veil(_OfFacets):
    """Translucent surfaces, which do not hide what is drawn later."""

    opacity: float

    def on(self, canvas: Canvas) -> None:
        """Draw the layer."""
        _mix(canvas, self.facets, self.opacity, draw)


@dataclass(frozen=True, eq=False)
class Sky(Layer):
    """What is behind everything: a colour that changes from the top of the picture to its foot.

    Args:
        top: RGB in 0..255, shape (3,).
        foot: The same at the lower edge.
        height: Of the whole picture in [pixel].
        row: Of the canvas's first row in it.
    """

    top: Array
    foot: Array
    height: int
    row: int = 0

    def on(self, canvas: Canvas) -> None:
        """Fill the canvas; it is drawn before everything else."""
        if (self.top == self.foot).all() and (canvas.color[0, 0] == self.top.round()).all():
            return
        rows = self.row + np.arange(canvas.size[1])
        share = np.clip(np.round(SHADES * rows / self.height) / SHADES, 0.0, 1.0)[:, None]
        color = (1.0 - share) * self.top + share * self.foot
        canvas.color[:] = (color + 0.5).astype(np.uint8)[:, None]

    def within(self, box: Box) -> Layer:
        """Return the layer clipped to a box."""
        return replace(self, row=self.row + box[1])


@dataclass(frozen=True, eq=False)
class Shadows(Layer):
    """Shadows on the ground: triangles of shape (m, 3, 3), one entry per lamp."""

    corners: Sequence[Array]

    @cached_property
    def _reaches(self) -> list[Array]:
        return [_reach(corners) for corners in self.corners]

    def on(self, canvas: Canvas) -> None:
        """Draw the layer."""
        darken(canvas, self.corners, SHADOW ** (1.0 / LIGHT_SAMPLES))

    def within(self, box: Box) -> Layer:
        """Return the layer clipped to a box."""
        cuts = [_seen(reach, box) for reach in self._reaches]
        return Shadows(
            [
                corners[seen] - shift
                for corners, (seen, shift) in zip(self.corners, cuts, strict=True)
            ]
        )


def _reach(corners: Array) -> Array:
    """Bounding boxes of triangles: least column and row, then largest, shape (4, m)."""
    places = corners[:, :, :2]
    return np.concatenate([places.min(axis=1), places.max(axis=1)], axis=1).T.copy()


def _seen(reach: Array, box: Box) -> tuple[NDArray[np.intp], Array]:
    """Indices of the triangles that overlap a box, and its origin, shape (3,)."""
    left, top, right, bottom = box
    seen = (reach[0] < right) & (reach[1] < bottom) & (reach[2] > left) & (reach[3] > top)
    return np.flatnonzero(seen), np.array([left, top, 0.0])


def drawn(layers: Sequence[Layer], size: tuple[int, int], paper: ArrayLike) -> Canvas:
    """Draw layers on a background of a colour (r, g, b)."""
    canvas = blank(size, paper)
    for layer in layers:
        layer.on(canvas)
    return canvas


def _mix(
    canvas: Canvas, facets: Facets, opacity: float, drawing: Callable[[Canvas, Facets], None]
) -> None:
    """Draw facets in one way or another on a copy, and mix what changes with what was there."""
    if not len(facets.corners):
        return
    layer = canvas.part((0, 0, *canvas.size))
    drawing(layer, facets)
    left, top, right, bottom = extent(facets.corners, canvas.size)
    below, above = (each.color[top:bottom, left:right] for each in (canvas, layer))
    where = (above != below).any(axis=-1)
    mixed = (1.0 - opacity) * below[where] + opacity * above[where]
    below[where] = (mixed + 0.5).astype(np.uint8)
