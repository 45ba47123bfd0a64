"""Rank of sets of vectors, by singular values or by exact elimination."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import sympy
from numpy.typing import NDArray
from sympy.polys.matrices import DomainMatrix

Vectors: TypeAlias = NDArray[Any]  # one per row, of floats or Fractions; shape (count, n)

RANK_TOLERANCE = 1e-8  # of the largest singular value


@dataclass(frozen=True)
class Rank:
    """A numerical rank with its singular value gap.

    Attributes:
        value: The rank.
        smallest: Smallest singular value counted, relative to the largest; 1 where exact.
        largest_ignored: Largest singular value counted as 0, likewise; 0 where exact.
    """

    value: int
    smallest: float = 1.0
    largest_ignored: float = 0.0


def rank_of(
    vectors: Vectors, tolerance: float = RANK_TOLERANCE, sizes: NDArray[np.float64] | None = None
) -> Rank:
    """Return the rank of a set of vectors.

    Floats are equilibrated first, so that neither units nor the norms of vectors matter.

    Args:
        vectors: Shape (count, n); Fractions (dtype object) are eliminated exactly.
        tolerance: Fraction of the largest singular value below which one counts as 0.
        sizes: Effective magnitude of each entry for the scaling, same shape, so that entries at
            rounding level are not amplified. The entries' absolute values when left out.

    Source: Golub, Van Loan, Matrix Computations, 4th ed., section 5.5.
    """
    if vectors.dtype == object:
        rows = [[sympy.QQ(x.numerator, x.denominator) for x in row] for row in vectors]
        return Rank(DomainMatrix(rows, vectors.shape, sympy.QQ).rank())
    if not vectors.size or not np.abs(vectors).max():
        return Rank(0)
    heights, widths = scales_of(np.abs(vectors) if sizes is None else sizes)
    values = np.linalg.svd(vectors / heights / widths, compute_uv=False)
    shares = values / values[0]
    count = int((shares > tolerance).sum())
    ignored = float(shares[count]) if count < len(shares) else 0.0
    return Rank(count, float(shares[count - 1]), ignored)


def scales_of(sizes: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return row and column divisors that make the largest entry of each about 1.

    Args:
        sizes: Magnitudes of the entries, shape (m, n), nonnegative.

    Returns:
        Shapes (m, 1) and (1, n), all positive.
    """
    rows, columns = np.ones((len(sizes), 1)), np.ones((1, sizes.shape[1]))
    for _ in range(4):  # of alternating row and column scaling (equilibration)
        columns = columns * _positive((sizes / rows / columns).max(axis=0, keepdims=True))
        rows = rows * _positive((sizes / rows / columns).max(axis=1, keepdims=True))
    return rows, columns


def _positive(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(values > 0, values, 1.0)


def reduced_rows(
    rows: NDArray[np.float64], tolerance: float = RANK_TOLERANCE
) -> NDArray[np.float64]:
    """Return the reduced row echelon form of a matrix (m, n), shape (rank, n).

    It depends only on the row space and the order of the columns.
    """
    matrix, lead = np.array(rows, dtype=float), 0
    size = np.abs(matrix).max(initial=0.0)
    for column in range(matrix.shape[1]):
        if lead == len(matrix):
            break
        pivot = lead + int(np.abs(matrix[lead:, column]).argmax())
        if abs(matrix[pivot, column]) <= tolerance * size:
            matrix[lead:, column] = 0.0
            continue
        matrix[[lead, pivot]] = matrix[[pivot, lead]]
        matrix[lead] /= matrix[lead, column]
        others = np.arange(len(matrix)) != lead
        matrix[others] -= np.outer(matrix[others, column], matrix[lead])
        lead += 1
    matrix[np.abs(matrix) <= tolerance] = 0.0
    return matrix[:lead]
