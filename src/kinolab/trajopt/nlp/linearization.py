"""A trajectory's surroundings, linearised, and a change within them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.nlp.linear_inequalities import Rows
from kinolab.trajopt.nlp.scaling import Scaling

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Local:
    """A trajectory's surroundings, linearised.

    Attributes:
        knots: Where.
        defects: Where each step leads less the next knot, shape (N, nx).
        tangents: Derivatives of where the steps lead, shape (N, nx, nx + nu + 1).
        rows: Inequalities.
        miss: What is missing in the goal, shape (m,), as shares of what counts as large.
        dmiss: Its derivative with respect to the last state, shape (m, nx).
    """

    knots: Knots
    defects: Array
    tangents: Array
    rows: Rows
    miss: Array
    dmiss: Array

    def open_defects(self, scaling: Scaling) -> float:
        """Return the sum of all defects, in scales."""
        return float(np.abs(self.defects / scaling.x).sum())

    def missing(self, scaling: Scaling) -> float:
        """Return the sum of all that is missing."""
        goal = float(np.abs(self.miss).sum())
        return self.rows.violation + goal + self.open_defects(scaling)


@dataclass(frozen=True, eq=False)
class Change:
    """What changes, and by how much the model says that the merit falls.

    ``length`` is the largest change of any variable, as a share of what counts as large;
    ``iterations`` is how many systems of equations it took.
    """

    dx: Array
    du: Array
    dh: float
    promised: float
    length: float
    iterations: int


def change_of(
    knots: Knots,
    scaling: Scaling,
    shares: tuple[Array, Array, float],
    promised: float,
    iterations: int,
) -> Change:
    """Return a change that is given in shares of what counts as large: states, inputs, step."""
    x, u, h = shares
    length = max(float(np.abs(part).max(initial=0.0)) for part in (x, u, np.array([h])))
    return Change(x * scaling.x, u * scaling.u, h * knots.h, promised, length, iterations)
