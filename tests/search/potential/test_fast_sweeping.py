"""Arrival times of a front, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from kinolab.search.potential.fast_sweeping import arrival_times

Array = NDArray[np.float64]


def corners(shape: tuple[int, ...]) -> Array:
    """Coordinates of all corners of cells, shape (nx + 1, ny + 1, …, axes)."""
    return np.stack(np.meshgrid(*(np.arange(n + 1.0) for n in shape), indexing="ij"), axis=-1)


def growing(cells: int, dims: int) -> tuple[Array, Array, Array]:
    """Speed that grows along a slope in a unit box: speed, source, and exact times.

    Rays are arcs of circles. Source: Slotnick, Lessons in seismic computing, 1959.
    """
    slope = np.array([1.0, 2.0, -0.5])[:dims]
    source = np.full(dims, cells // 4)
    middle = np.stack(
        np.meshgrid(*[(np.arange(cells) + 0.5) / cells] * dims, indexing="ij"), axis=-1
    )
    away = (corners((cells,) * dims) - source) / cells
    at_source = 1.5 + slope @ source / cells
    speed, there = 1.5 + middle @ slope, at_source + away @ slope
    squares = (slope @ slope) * (away**2).sum(axis=-1)
    return (
        speed,
        source,
        np.arccosh(1.0 + squares / (2.0 * at_source * there)) / np.sqrt(slope @ slope),
    )


@pytest.mark.parametrize("shape", [(40, 31), (17, 20, 23), (1, 9), (5, 1, 1)])
def test_in_the_open_times_are_distances(shape: tuple[int, ...]) -> None:
    """Fronts are spheres, whose curvature is corrected for exactly."""
    source = np.array([n // 3 for n in shape])
    distance = np.linalg.norm(corners(shape) - source, axis=-1)
    times = arrival_times(np.full(shape, 2.0), source)
    np.testing.assert_allclose(times, distance / 2.0, rtol=1e-12, atol=0)


@pytest.mark.parametrize("dims", [2, 3])
def test_the_error_is_of_first_order(dims: int) -> None:
    """Halved cells halve the error, where speed is held in each cell."""
    errors = []
    for cells in (16, 32):
        speed, source, exact = growing(cells, dims)
        errors.append(np.abs(arrival_times(speed, source) / cells - exact).max())
    assert errors[1] < 0.62 * errors[0]  # a half but for terms of higher order
    assert errors[1] < 0.5 / 32 / 1.5  # half a cell at the speed in the corner


def test_a_front_goes_round_through_the_fast_layer() -> None:
    """Below a slow layer lies a fast one: far away, the way down, along and up is the quickest.

    Source: the head wave of seismology, t = x / v2 + 2 h sqrt(1 / v1^2 - 1 / v2^2).
    """
    h, slow, fast = 10, 1.0, 3.0
    speed = np.full((100, 20), slow)
    speed[:, :h] = fast
    times = arrival_times(speed, np.array([0, 2 * h]))
    down_and_up = 2 * h * np.sqrt(1 / slow**2 - 1 / fast**2)
    assert times[100, 2 * h] == pytest.approx(100 / fast + down_and_up, rel=0.02)
    assert times[8, 2 * h] == pytest.approx(8.0, rel=1e-9)  # near by, straight ahead


@pytest.mark.parametrize("dims", [2, 3])
def test_axes_are_treated_alike(dims: int) -> None:
    """A world that is mirrored or turned has mirrored or turned times, but for rounding."""
    speed = np.random.default_rng(dims).choice([1e-3, 0.2, 1.0], (9,) * dims)
    source = np.arange(2, 2 + dims)
    times = arrival_times(speed, source)
    mirrored = arrival_times(speed[::-1], np.array([9 - source[0], *source[1:]]))[::-1]
    turned = arrival_times(speed.T.copy(), source[::-1]).T
    np.testing.assert_allclose(mirrored, times, rtol=1e-12)
    np.testing.assert_allclose(turned, times, rtol=1e-12)


@pytest.mark.parametrize("dims", [2, 3])
def test_times_are_between_those_of_the_highest_and_the_lowest_speed(dims: int) -> None:
    random = np.random.default_rng(dims)
    for _ in range(50):
        speed = random.uniform(0.2, 1.0, (8,) * dims)
        source = random.integers(0, 9, dims)
        distance = np.linalg.norm(corners(speed.shape) - source, axis=-1)
        times = arrival_times(speed, source)
        assert (times >= distance / speed.max()).all()
        assert (times <= distance / speed.min() * (1 + 1e-12)).all()
        np.testing.assert_allclose(arrival_times(speed / 2, source), 2 * times, rtol=1e-13)
