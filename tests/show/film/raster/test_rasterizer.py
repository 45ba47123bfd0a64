"""Which pixels a triangle takes."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.show.film.raster.rasterizer import (
    GROUND,
    Canvas,
    Facets,
    average,
    blank,
    darken,
    draw,
    extent,
)

WHITE, RED, BLUE = (255, 255, 255), (255, 0, 0), (0, 0, 255)


def triangle(points: object, nearness: object, color: object = RED) -> Facets:
    corners = np.column_stack([np.asarray(points, float), np.broadcast_to(nearness, 3)])
    return Facets(corners[None], np.array([color], dtype=np.uint8))


def painted(canvas: Canvas, color: object = RED) -> np.ndarray:
    return np.asarray((canvas.color == np.array(color)).all(axis=-1))


@pytest.mark.parametrize("nearest_first", [True, False])
def test_the_nearer_triangle_wins_in_whatever_order(nearest_first: bool) -> None:
    near = triangle([[5, 5], [35, 5], [5, 35]], 1.0, RED)
    far = triangle([[0, 0], [40, 0], [0, 40]], 0.5, BLUE)
    canvas = blank((50, 50), WHITE)
    draw(canvas, near + far if nearest_first else far + near)
    assert tuple(canvas.color[10, 10]) == RED
    assert tuple(canvas.color[2, 2]) == BLUE


def test_two_crossing_triangles_part_where_their_depths_agree() -> None:
    """Nearness 1 at every column meets nearness column / 50 at column 50."""
    level = triangle([[0, 0], [200, 0], [0, 200]], 1.0, RED)
    tilted = triangle([[0, 0], [200, 0], [0, 200]], [1e-9, 4.0, 1e-9], BLUE)
    canvas = blank((100, 20), WHITE)
    draw(canvas, level + tilted)
    assert painted(canvas, RED)[:, :49].all()
    assert painted(canvas, BLUE)[:, 51:].all()


@pytest.mark.parametrize("seed", range(10))
def test_the_pixels_of_a_triangle_are_as_many_as_its_area(seed: int) -> None:
    """The boundary rounds by about a pixel per row, which is below 1 % at this size."""
    angle = np.random.default_rng(seed).uniform(0, 2 * np.pi) + np.array([0.0, 1.5, 3.5])
    points = 1000.0 + 950.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    (ax, ay), (bx, by) = points[1] - points[0], points[2] - points[0]
    area = 0.5 * abs(ax * by - bx * ay)
    canvas = blank((2000, 2000), WHITE)
    draw(canvas, triangle(points, 1.0))
    assert painted(canvas).sum() == pytest.approx(area, rel=0.01)


@pytest.mark.parametrize("seed", range(10))
def test_neighbours_neither_overlap_nor_leave_a_gap(seed: int) -> None:
    """Four triangles around an inner point fill the square of 40 x 40 pixels exactly once."""
    inner = np.random.default_rng(seed).uniform(15, 45, 2)
    ring = np.array([[10.0, 10], [50, 10], [50, 50], [10, 50]])
    count = np.zeros((60, 60), dtype=int)
    for i in range(4):
        canvas = blank((60, 60), WHITE)
        draw(canvas, triangle([ring[i], ring[(i + 1) % 4], inner], 1.0))
        count += painted(canvas)
    assert (count[10:50, 10:50] == 1).all()
    assert count.sum() == 40 * 40


@pytest.mark.parametrize("bad", [-1.0, 0.0, np.nan, np.inf])
def test_a_triangle_that_reaches_behind_the_camera_is_left_out(bad: float) -> None:
    canvas = blank((50, 50), WHITE)
    corners = np.array([[[5, 5, 1.0], [35, 5, 1.0], [5, 35, 1.0]]])
    corners[0, 1, 2 if bad <= 0.0 else 0] = bad
    draw(canvas, Facets(corners, np.array([RED], dtype=np.uint8)))
    assert not painted(canvas).any()


def test_a_shadow_darkens_the_ground_once_per_lamp_and_nothing_else() -> None:
    canvas = blank((40, 20), (200, 200, 200))
    canvas.kind[:, :20] = GROUND
    square = np.array(
        [[[0, 0, 1], [40, 0, 1], [40, 20, 1]], [[0, 0, 1], [40, 20, 1], [0, 20, 1.0]]]
    )
    half = np.full(3, 0.5)
    darken(canvas, [square], half)
    darken(canvas, [square], half)
    assert (canvas.color[:, :20] == 100).all()
    assert (canvas.color[:, 20:] == 200).all()
    darken(canvas, [square, square], half)
    assert (canvas.color[:, :20] == 50).all()


def test_the_extent_contains_every_painted_pixel() -> None:
    corners = triangle([[7.3, 11.8], [31.6, 13.0], [9.9, 44.2]], 1.0).corners
    left, top, right, bottom = extent(corners, (60, 60), 3)
    assert (left % 3, top % 3, right % 3, bottom % 3) == (0, 0, 0, 0)
    assert left <= 7
    assert top <= 11
    assert right >= 32
    assert bottom >= 45


def test_averaging_keeps_a_constant_and_the_mean_of_a_checkerboard() -> None:
    board = np.zeros((4, 6, 3), dtype=np.uint8)
    board[::2, ::2] = board[1::2, 1::2] = 200
    assert (average(board, 2) == 100).all()
    assert average(board, 2).shape == (2, 3, 3)
