"""Intervals against mpmath's, which has its own rounding, and against points inside."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import iv

from kinolab.numerics import intervals
from kinolab.numerics.intervals import ON_INTERVALS, IntervalArray

BINARY = ("add", "sub", "mul", "div", "fmax")
UNARY = sorted(set(ON_INTERVALS) - set(BINARY))
OF_MPMATH = {
    "sin": iv.sin,
    "cos": iv.cos,
    "tan": iv.tan,
    "exp": iv.exp,
    "log": iv.log,
    "sqrt": iv.sqrt,
}
AT_POINTS: dict[str, Any] = {
    **{name: getattr(np, name) for name in ("sin", "cos", "tan", "exp", "tanh", "sign")},
    **{"fabs": np.abs, "atan": np.arctan, "neg": np.negative, "fmax": np.maximum},
    **{"add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide},
    **{"log": np.log, "sqrt": np.sqrt},
}
COUNT, INSIDE = 400, 50


def boxes(seed: int) -> IntervalArray:
    """Return intervals of all widths about places of all sizes, some of them single numbers."""
    rng = np.random.default_rng(seed)
    middle = rng.normal(size=COUNT) * 10 ** rng.uniform(-3, 2, COUNT)
    half = np.where(rng.random(COUNT) < 0.1, 0.0, 10 ** rng.uniform(-8, 1.5, COUNT))
    return IntervalArray(middle - half, middle + half)


def inside(a: IntervalArray, seed: int) -> np.ndarray[Any, Any]:
    """Return points of every interval, its ends among them, shape (INSIDE, COUNT)."""
    share = np.random.default_rng(seed).random((INSIDE, COUNT))
    share[0], share[1] = 0.0, 1.0
    return np.clip(a.low + share * a.width, a.low, a.high)


def holds(found: IntervalArray, values: np.ndarray[Any, Any]) -> bool:
    sound = ~np.isnan(values)  # where there is no value, nothing is to be held
    return bool(((values >= found.low) & (values <= found.high))[sound].all())


@pytest.mark.parametrize("name", UNARY)
def test_what_a_function_does_to_points_is_inside(name: str) -> None:
    a = boxes(1)
    with np.errstate(all="ignore"):
        found, values = ON_INTERVALS[name](a), AT_POINTS[name](inside(a, 2))
    assert holds(found, values)


@pytest.mark.parametrize("name", BINARY)
def test_what_an_operation_does_to_points_is_inside(name: str) -> None:
    a, b = boxes(3), boxes(4)
    with np.errstate(all="ignore"):
        found, values = ON_INTERVALS[name](a, b), AT_POINTS[name](inside(a, 5), inside(b, 6))
    assert holds(found, values)


@pytest.mark.parametrize("name", sorted(OF_MPMATH))
def test_functions_are_as_narrow_as_those_of_another_library(name: str) -> None:
    a = boxes(7)
    if name in ("log", "sqrt"):
        a = IntervalArray(np.abs(a.low) + 1e-6, np.abs(a.low) + 1e-6 + a.width)
    with np.errstate(all="ignore"):
        found = ON_INTERVALS[name](a)
    for low, high, least, most in zip(a.low, a.high, found.low, found.high, strict=True):
        theirs = OF_MPMATH[name](iv.mpf([low, high]))
        if not np.isfinite([float(theirs.a), float(theirs.b)]).all():
            continue
        slack = 1e-11 * (1.0 + abs(float(theirs.a)) + abs(float(theirs.b)))
        assert least <= float(theirs.b)
        assert float(theirs.a) - slack <= least or name == "tan"
        assert most <= float(theirs.b) + slack or name == "tan"


def test_a_square_is_never_negative() -> None:
    found = intervals.square(IntervalArray(np.array([-1.0, 2.0]), np.array([3.0, 3.0])))
    assert found.low[0] == 0.0
    assert found.high == pytest.approx([9.0, 9.0])
    assert found.low[1] == pytest.approx(4.0)


def test_an_angle_of_any_size_has_a_sine_between_minus_one_and_one() -> None:
    wild = IntervalArray(np.array([-np.inf, 1e300]), np.array([np.inf, 2e300]))
    with np.errstate(all="ignore"):
        found = intervals.sin(wild)
    assert (found.low == -1.0).all()
    assert (found.high == 1.0).all()


def test_division_by_what_may_be_zero_is_anything() -> None:
    found = intervals.div(
        intervals.point(np.ones(1)), IntervalArray(np.array([-1.0]), np.array([1.0]))
    )
    assert found.low[0] == -np.inf
    assert found.high[0] == np.inf
