"""Factors of a matrix solve its equations, whatever the order of its rows, or say that none do."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.numerics.lu import factor, substitute


@pytest.mark.parametrize("n", [1, 2, 7])
def test_the_solution_fulfils_the_equations(n: int) -> None:
    """Rounding leaves about n times 1e-16 of a matrix of condition 10."""
    generator = np.random.default_rng(n)
    A = generator.uniform(-1, 1, (n, n)) + 2 * n * np.eye(n)[::-1]  # large beside the diagonal
    b = generator.uniform(-1, 1, n)
    factors, pivots, z = A.copy(), np.empty(n), b.copy()
    assert factor(factors, pivots) == 0
    substitute(factors, pivots, z)
    np.testing.assert_allclose(A @ z, b, rtol=0, atol=1e-14)


def test_a_zero_on_the_diagonal_is_no_obstacle() -> None:
    factors, pivots, z = np.array([[0.0, 2.0], [4.0, 0.0]]), np.empty(2), np.array([6.0, 8.0])
    assert factor(factors, pivots) == 0
    substitute(factors, pivots, z)
    assert z.tolist() == [2.0, 3.0]


def test_a_singular_matrix_is_told() -> None:
    assert factor(np.array([[1.0, 2.0], [2.0, 4.0]]), np.empty(2)) == 1
