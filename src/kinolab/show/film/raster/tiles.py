"""A large backdrop of which a window is shown: drawn tile by tile, and kept."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product

from kinolab.show.film.raster.draw_list import Layer, drawn
from kinolab.show.film.raster.rasterizer import Box, Canvas, empty

TILE = 256  # [pixel] per side


@dataclass(frozen=True, eq=False)
class Tiles:
    """Layers on a canvas of any size; a window that moves slowly costs only what is new in it.

    Args:
        layers: In drawing order.
        paper: Colour of the background (r, g, b) in 0..255.
    """

    layers: Sequence[Layer]
    paper: tuple[int, int, int]

    def window(self, box: Box) -> Canvas:
        """The layers inside a box, which may reach beyond the picture."""
        left, top, right, bottom = box
        canvas = empty((right - left, bottom - top))
        for row, column in product(_tiles(top, bottom), _tiles(left, right)):
            tile, x, y = self._tile(column, row), column * TILE, row * TILE
            low, high = max(x, left), min(x + TILE, right)
            upper, lower = max(y, top), min(y + TILE, bottom)
            there = (slice(upper - top, lower - top), slice(low - left, high - left))
            here = (slice(upper - y, lower - y), slice(low - x, high - x))
            canvas.color[there] = tile.color[here]
            canvas.nearness[there] = tile.nearness[here]
            canvas.kind[there] = tile.kind[here]
        return canvas

    @cached_property
    def _tile(self) -> Callable[[int, int], Canvas]:
        """A tile by column and row, which threads may draw twice; the oldest ones are forgotten."""
        return lru_cache(96)(self._drawn)  # 0.5 MB each

    def _drawn(self, column: int, row: int) -> Canvas:
        box = (column * TILE, row * TILE, (column + 1) * TILE, (row + 1) * TILE)
        return drawn([layer.within(box) for layer in self.layers], (TILE, TILE), self.paper)


def _tiles(low: int, high: int) -> Iterator[int]:
    """The tiles that an interval of pixels overlaps."""
    yield from range(low // TILE, -(-high // TILE))
