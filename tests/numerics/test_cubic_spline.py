"""Cubic splines are what SciPy makes of the same samples."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.interpolate

from kinolab.numerics.cubic_spline import CubicSpline


@pytest.mark.parametrize("count", [4, 5, 120])
def test_a_spline_is_scipys(count: int) -> None:
    generator = np.random.default_rng(count)
    x = np.cumsum(generator.uniform(0.01, 1.0, count))
    y = generator.normal(size=(count, 3))
    places = np.concatenate([x, generator.uniform(x[0] - 0.1, x[-1] + 0.1, 200)])
    expected = scipy.interpolate.CubicSpline(x, y)(places)
    assert CubicSpline(x, y)(places) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_cubic_is_its_own_spline() -> None:
    x = np.array([-1.0, -0.4, 0.1, 0.7, 1.5])
    places = np.linspace(-2.0, 2.0, 50)

    def cubic(t: np.ndarray) -> np.ndarray:
        return np.column_stack([t**3 - 2 * t, 1.0 - t**2])

    assert CubicSpline(x, cubic(x))(places) == pytest.approx(cubic(places), abs=1e-12)
