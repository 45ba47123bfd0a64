"""A trajectory's surroundings, linearised."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.trajopt.nlp.decision import Knots, Scaling
from kinolab.trajopt.nlp.path_constraints import LinearInequalities


@dataclass(frozen=True, eq=False)
class Linearization:
    """A trajectory's surroundings, linearised.

    Attributes:
        knots: Where.
        defects: Where each step leads less the next knot, shape (N, nx).
        sensitivities: Derivatives of where the steps lead, shape (N, nx, nx + nu + 1).
        rows: Inequalities.
        goal_residual: What is missing in the goal, shape (m,), as shares of what counts as large.
        goal_jacobian: Its derivative with respect to the last state, shape (m, nx).
    """

    knots: Knots
    defects: Array
    sensitivities: Array
    rows: LinearInequalities
    goal_residual: Array
    goal_jacobian: Array

    def open_defects(self, scaling: Scaling) -> float:
        """Return the sum of all defects, in scales."""
        return float(np.abs(self.defects / scaling.x).sum())

    def violation(self, scaling: Scaling) -> float:
        """Return the sum of all that is missing."""
        goal = float(np.abs(self.goal_residual).sum())
        return self.rows.violation + goal + self.open_defects(scaling)
