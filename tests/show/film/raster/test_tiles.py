"""A window on tiles shows what drawing the whole would."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.show.film.raster.draw_list import FloorPaint, Shadows, Solid, Veil, drawn
from kinolab.show.film.raster.rasterizer import GROUND, Facets
from kinolab.show.film.raster.tiles import TILE, Tiles

SIZE = (3 * TILE, 2 * TILE)
PAPER = (250, 250, 248)


def facets(seed: int, count: int) -> Facets:
    """Triangles all over the picture, of several tiles each."""
    random = np.random.default_rng(seed)
    corners = random.uniform(0.1, 0.9, (count, 3, 3)) * [*SIZE, 1.0]
    return Facets(corners, random.integers(0, 255, (count, 3), dtype=np.uint8))


@pytest.mark.parametrize("box", [(0, 0, *SIZE), (TILE - 7, 11, 2 * TILE + 5, TILE + 3)])
def test_a_window_is_the_same_part_of_the_whole(box: tuple[int, int, int, int]) -> None:
    layers = [
        Solid(facets(1, 3), GROUND),
        FloorPaint(facets(2, 5), 0.3),
        Solid(facets(3, 9)),
        Shadows([facets(4, 2).corners, facets(5, 2).corners]),
        Veil(facets(6, 4), 0.45),
    ]
    whole, tiles = drawn(layers, SIZE, PAPER).part(box), Tiles(layers, PAPER)
    for _ in range(2):  # drawn, then remembered
        window = tiles.window(box)
        assert (window.kind == whole.kind).all()
        assert (window.color == whole.color).all()
        assert np.abs(window.nearness - whole.nearness).max() < 1e-6  # of 1; single precision


def test_beyond_the_picture_there_is_paper_and_few_tiles_are_kept() -> None:
    tiles = Tiles([Solid(facets(1, 3))], PAPER)
    assert (tiles.window((-TILE, -TILE, 0, 0)).color == PAPER).all()
    for row in range(192):
        tiles.window((0, row * TILE, TILE, (row + 1) * TILE))
    assert tiles._tile.cache_info().currsize == 96  # type: ignore[attr-defined]
