"""Zonotopes against points inside, and Taylor series of intervals against mpmath's."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.linalg import expm

from kinolab.numerics import intervals
from kinolab.numerics.interval_analysis.interval_matrices import growth
from kinolab.numerics.interval_analysis.interval_series import Expansion, beginning
from kinolab.numerics.interval_analysis.taylor_recurrences import further
from kinolab.numerics.interval_analysis.zonotopes import Zonotope
from kinolab.numerics.intervals import IntervalArray

Array = np.ndarray[Any, np.dtype[np.float64]]
UNARY = ("sin", "cos", "tan", "exp", "log", "sqrt", "tanh", "atan")
ORDER = 6


def zonotope(seed: int) -> Zonotope:
    rng = np.random.default_rng(seed)
    return Zonotope(rng.normal(size=3), rng.normal(size=(3, 2)), rng.normal(size=(3, 40)))


def support(one: Zonotope, directions: Array) -> Array:
    """Return the largest scalar product with each direction: exact, but for rounding."""
    return directions @ one.centre + np.abs(directions @ one.generators).sum(axis=1)


@pytest.mark.parametrize("seed", range(5))
def test_a_reduced_zonotope_holds_the_other_and_keeps_what_lasts(seed: int) -> None:
    one = zonotope(seed)
    less = one.reduced(9, np.ones(3))
    directions = np.random.default_rng(seed).normal(size=(200, 3))
    assert less.free.shape[1] == 9
    assert np.array_equal(less.lasting, one.lasting)
    assert (support(less, directions) >= support(one, directions) - 1e-12).all()


def test_maps_and_sums_hold_those_of_points() -> None:
    one, rng = zonotope(1), np.random.default_rng(2)
    matrix, shift, new = rng.normal(size=(2, 3)), rng.normal(size=2), rng.normal(size=(2, 4))
    made = one.mapped(matrix).plus(shift, new)
    for _ in range(200):
        a, b, c = (rng.choice([-1.0, 1.0], n) for n in (2, 40, 4))
        point = matrix @ (one.centre + one.lasting @ a + one.free @ b) + shift + new @ c
        assert ((made.bounds.low <= point) & (point <= made.bounds.high)).all()


@pytest.mark.parametrize("name", UNARY)
def test_series_of_functions_hold_those_of_another_library(name: str) -> None:
    """Of f(0.7 + 0.3 t - 0.2 t^2), in 50 digits; derivatives by 0.7 by central differences."""
    polynomial = [0.7, 0.3, -0.2]
    a = Expansion(row(polynomial[0], 1.0), steady=False)
    for n in range(1, ORDER):
        a.append(row(polynomial[n] if n < 3 else 0.0, 0.0))
    own, helper = Expansion(beginning(name, [a[0]]), steady=False), {}
    for n in range(1, ORDER):
        own.append(further(name, n, [a], own, helper))
    with mpmath.workdps(50):
        exact = taylor(name, polynomial, mpmath.mpf(0))
        ends = [taylor(name, polynomial, sign * mpmath.mpf(10) ** -20) for sign in (-1, 1)]
        slopes = [(up - down) / (2 * mpmath.mpf(10) ** -20) for down, up in zip(*ends, strict=True)]
    for n in range(ORDER):
        for value, place in ((exact[n], 0), (slopes[n], 1)):
            assert own.low[n, place, 0] <= value <= own.high[n, place, 0]
            assert own.high[n, place, 0] - own.low[n, place, 0] < 1e-10


def row(value: float, slope: float) -> IntervalArray:
    return intervals.point(np.array([[value], [slope]]))


def taylor(name: str, polynomial: list[float], off: Any) -> list[Any]:
    function = getattr(mpmath, name)
    first, second, third = map(mpmath.mpf, polynomial)
    return mpmath.taylor(lambda t: function(first + off + second * t + third * t * t), 0, ORDER)


def test_growth_bounds_exponentials() -> None:
    """Of matrices of all sizes, with a row of another unit; SciPy's exponential of the whole."""

    rng = np.random.default_rng(3)
    for scale in (1e-3, 0.1, 1.0):
        N, B = scale * rng.random((3, 3)), scale * rng.random((3, 2))
        N[0] *= 1e3
        N[:, 0] *= 1e-3
        whole = expm(np.block([[N, B], [np.zeros((2, 5))]])) - np.eye(5)
        states, inputs = growth(N[:, :, None], B[:, :, None])
        found = np.hstack([states[..., 0], inputs[..., 0]])
        assert (found >= whole[:3] * (1.0 - 1e-12)).all()
        assert (found <= whole[:3] * 1.001).all()
