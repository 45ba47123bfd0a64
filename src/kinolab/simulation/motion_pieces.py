"""A re-simulated motion as polynomial pieces, each in a box that contains all of it.

A polynomial lies between the smallest and the largest of its Bernstein coefficients, and halving
its interval brings them nearer to it, by a fourth each time.

Source: Farouki, The Bernstein polynomial basis: a centennial retrospective, Computer Aided
Geometric Design 29(6), 2012, sections 3 and 4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.columnar import Columns
from kinolab.numerics.intervals import IntervalArray
from kinolab.simulation.dop853 import POWER, StepTable


@dataclass(frozen=True, eq=False)
class MotionPieces(Columns):
    """Pieces of integrator steps, a row each.

    Attributes:
        step: The integrator step that each is a part of, shape (m,).
        knots: The interval of that step between two knots, shape (m,).
        begin: In [s], shape (m,).
        end: In [s], shape (m,).
        coefficients: Bernstein coefficients of the state, shape (m, 8, nx).
    """

    step: NDArray[np.intp]
    knots: NDArray[np.int64]
    begin: Array
    end: Array
    coefficients: Array

    @classmethod
    def of(cls, table: StepTable) -> MotionPieces:
        """Return the steps of an integration, each as a whole."""
        among = np.einsum("ij,mjk->mik", _to_bernstein(), table.coefficients)
        coefficients = table.x[:, None, :] + among
        steps = np.arange(len(table.begin))
        return cls(steps, table.knot, table.begin, table.end, coefficients)

    @property
    def box(self) -> IntervalArray:
        """Boxes of the states in each piece, shape (m, nx)."""
        low, high = self.coefficients.min(axis=1), self.coefficients.max(axis=1)
        return intervals.wider(IntervalArray(low, high))

    @property
    def ends(self) -> tuple[Array, Array]:
        """The states at both ends of each, two of shape (m, nx)."""
        return self.coefficients[:, 0], self.coefficients[:, -1]

    @property
    def divisible(self) -> NDArray[np.bool_]:
        """Whether each is long enough to be halved, shape (m,)."""
        middle = 0.5 * (self.begin + self.end)
        return np.asarray((self.begin < middle) & (middle < self.end))

    def halves(self) -> MotionPieces:
        """Return the first halves, then the second ones, by de Casteljau's algorithm."""
        middle = 0.5 * (self.begin + self.end)
        level, left, right = self.coefficients, [], []
        while True:
            left.append(level[:, 0])
            right.append(level[:, -1])
            if level.shape[1] == 1:
                break
            level = 0.5 * (level[:, 1:] + level[:, :-1])
        first = MotionPieces(self.step, self.knots, self.begin, middle, np.stack(left, axis=1))
        other = np.stack(right[::-1], axis=1)
        last = MotionPieces(self.step, self.knots, middle, self.end, other)
        return MotionPieces.joined([first, last])


@cache
def _to_bernstein() -> Array:
    """Return what turns coefficients of the dense output into Bernstein coefficients, (8, 7).

    The dense output is a sum of s^a (1 - s)^b with a + b = 1, 2, … 7 and a = b or b + 1.
    """
    matrix = np.zeros((POWER + 1, POWER))
    for i in range(POWER):
        a, b = (i + 2) // 2, (i + 1) // 2
        for k in range(POWER - a - b + 1):
            matrix[a + k, i] = math.comb(POWER - a - b, k) / math.comb(POWER, a + k)
    return matrix
