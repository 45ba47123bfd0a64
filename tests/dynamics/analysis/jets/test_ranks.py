"""Ranks do not depend on units, nor on rounding; echelon forms on nothing but the span."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from kinolab.dynamics.analysis.jets.ranks import rank_of, reduced_rows


@pytest.mark.parametrize("seed", range(10))
def test_ranks_do_not_depend_on_units(seed: int) -> None:
    """Rows and columns by factors from 1e-6 to 1e6."""
    rng = np.random.default_rng(seed)
    vectors = rng.normal(size=(7, 3)) @ rng.normal(size=(3, 5))
    scaled = vectors * 10 ** rng.uniform(-6, 6, (7, 1)) * 10 ** rng.uniform(-6, 6, (1, 5))
    found = rank_of(scaled)
    assert found.value == 3
    assert found.smallest > 1e-4
    assert found.largest_ignored < 1e-13


def test_what_rounding_leaves_is_not_blown_up() -> None:
    """A component of 1e-16 that was 1 before it cancelled points nowhere."""
    vectors = np.array([[1.0, 0.0], [1.0, 1e-16]])
    sizes = np.maximum(np.abs(vectors), 1e-6)
    assert rank_of(vectors).value == 2
    assert rank_of(vectors, sizes=sizes).value == 1


def test_no_vectors_span_nothing() -> None:
    assert rank_of(np.zeros((0, 3))).value == rank_of(np.zeros((2, 3))).value == 0


def test_exact_elimination_tells_what_floats_cannot() -> None:
    """Two vectors that differ by 1e-30."""
    a, tiny = Fraction(1), Fraction(1, 10**30)
    vectors = np.array([[a, a], [a, a + tiny], [2 * a, a]], dtype=object)
    assert rank_of(vectors).value == 2
    assert rank_of(vectors[:2].astype(float)).value == 1


@pytest.mark.parametrize("seed", range(10))
def test_echelon_forms_depend_on_the_span_alone(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(3, 6))
    rows[:, 2] = 2 * rows[:, 0]  # a column without a pivot of its own
    mixed = rng.normal(size=(3, 3)) @ rows
    np.testing.assert_allclose(reduced_rows(mixed), reduced_rows(rows), atol=1e-9)
    assert np.linalg.matrix_rank(np.vstack([reduced_rows(rows), rows])) == 3


def test_dependent_rows_leave_no_row() -> None:
    rows = np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(reduced_rows(rows), [[1, 2, 0], [0, 0, 1]], atol=1e-12)
