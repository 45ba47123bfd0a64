"""Nearest neighbours against a look at all points."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.numerics.kd_forest import LEAF_SIZE, add, kd_forest, nearest
from kinolab.numerics.struct import Record

Array = np.ndarray


def square(points: Array, query: Array, period: Array) -> Array:
    apart = np.abs(points - query)
    with np.errstate(invalid="ignore"):
        other = np.where(np.isfinite(period), np.abs(period - apart), np.inf)
    return (np.minimum(apart, other) ** 2).sum(axis=1)


def planted(points: Array, period: Array) -> Record:
    found = Record(kd_forest(len(points), period))
    for point in points:
        add(found, point)
    return found


@pytest.mark.parametrize(
    "count", [1, 2, LEAF_SIZE - 1, LEAF_SIZE, LEAF_SIZE + 1, 3 * LEAF_SIZE, 1000, 5000, 40_000]
)
@pytest.mark.parametrize("dimensions", [1, 2, 6])
def test_no_point_is_nearer_by_more_than_a_tenth(count: int, dimensions: int) -> None:
    random = np.random.default_rng(count)
    period = np.where(np.arange(dimensions) % 2 == 1, 2.0, np.inf)
    points = random.uniform(-1, 1, (count, dimensions))
    trees = planted(points, period)
    for query in random.uniform(-1, 1, (100, dimensions)):
        name, found = nearest(trees, query, -1, np.inf)
        squares = square(points, query, period)
        assert squares[name] <= 1.1**2 * squares.min() + 1e-10
        assert found == pytest.approx(squares[name], rel=1e-4, abs=1e-10)


def test_every_point_finds_itself_at_any_time() -> None:
    random, period = np.random.default_rng(0), np.array([np.inf, 2.0, np.inf])
    points = random.normal(size=(700, 3)) * [1.0, 0.3, 5.0]
    trees = Record(kd_forest(700, period))
    for name, point in enumerate(points):
        add(trees, point)
        asked = int(random.integers(name + 1))
        assert nearest(trees, points[asked], -1, np.inf)[0] == asked


def test_equal_points_and_lines_of_points_are_no_harm() -> None:
    points = np.zeros((200, 2))
    points[100:, 0] = np.arange(100)
    trees = planted(points, np.full(2, np.inf))
    assert nearest(trees, np.array([57.2, 0.0]), -1, np.inf)[0] == 157
    assert nearest(trees, np.array([-1.0, 0.0]), -1, np.inf)[1] == 1.0


def test_nothing_beyond_the_best_so_far_is_found() -> None:
    trees = planted(np.array([[1.0], [2.0]]), np.full(1, np.inf))
    assert nearest(trees, np.zeros(1), 77, 0.5)[0] == 77
    assert nearest(kd_forest(10, np.full(1, np.inf)), np.zeros(1), 77, np.inf)[0] == 77
