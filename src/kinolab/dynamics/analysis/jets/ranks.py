"""Rank of sets of vectors, by singular values or by exact elimination."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Vectors: TypeAlias = NDArray[Any]  # one per row, of floats or Fractions; shape (count, n)

RANK_TOLERANCE = 1e-8  # of the largest singular value
SCALING_ROUNDS = 4  # of alternating row and column scaling (equilibration)


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
        return Rank(len(pivots_of(vectors)))
    if not vectors.size or not np.abs(vectors).max():
        return Rank(0)
    rows, columns = scales_of(np.abs(vectors) if sizes is None else sizes)
    values = np.linalg.svd(vectors / rows / columns, compute_uv=False)
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
    for _ in range(SCALING_ROUNDS):
        columns = columns * _positive((sizes / rows / columns).max(axis=0, keepdims=True))
        rows = rows * _positive((sizes / rows / columns).max(axis=1, keepdims=True))
    return rows, columns


def _positive(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.where(values > 0, values, 1.0)


def pivots_of(vectors: Vectors) -> list[int]:
    """Return the indices of vectors independent of those before them, by exact elimination."""
    reduced: list[tuple[int, list[Fraction]]] = []
    found = []
    for k, vector in enumerate(vectors):
        rest = list(vector)
        for lead, row in reduced:
            if rest[lead] != 0:
                rest = _minus(rest, row, rest[lead])
        lead = next((i for i, entry in enumerate(rest) if entry != 0), -1)
        if lead >= 0:
            reduced.append((lead, [entry / rest[lead] for entry in rest]))
            found.append(k)
    return found


def _minus(vector: Sequence[Fraction], row: Sequence[Fraction], factor: Fraction) -> list[Fraction]:
    return [a - factor * b for a, b in zip(vector, row, strict=True)]


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
