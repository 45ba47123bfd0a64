"""Polynomials of pieces: NumPy's have the same values, slopes and shifts."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from kinolab.search.flat.flat_pieces import begin_later, fit_cubic, fit_quintic, jet


@pytest.mark.parametrize("seed", range(5))
def test_a_jet_is_a_polynomial_with_its_derivatives(seed: int) -> None:
    c = np.random.default_rng(seed).normal(size=6)
    one = Polynomial(c)
    expected = [one(0.7), one.deriv()(0.7), one.deriv(2)(0.7), one.deriv(3)(0.7)]
    np.testing.assert_allclose(jet(c, 0.7), expected, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("seed", range(5))
def test_pieces_begin_and_end_as_they_are_asked_to(seed: int) -> None:
    T, *ends = np.random.default_rng(seed).uniform(0.5, 2.0, 7)
    c = np.full(6, np.nan)
    fit_quintic(c, T, *ends)
    met = [*jet(c, 0.0)[:3], *jet(c, T)[:3]]
    np.testing.assert_allclose(met, ends, rtol=1e-11)
    fit_cubic(c, T, *ends[:2], *ends[3:5])
    met = [*jet(c, 0.0)[:2], *jet(c, T)[:2]]
    np.testing.assert_allclose(met, [*ends[:2], *ends[3:5]], rtol=1e-12)


def test_a_piece_that_begins_later_goes_the_same_way() -> None:
    c = np.random.default_rng(0).normal(size=6)
    later = c.copy()
    begin_later(later, 0.4)
    np.testing.assert_allclose(Polynomial(later)(0.3), Polynomial(c)(0.7), rtol=1e-13)
