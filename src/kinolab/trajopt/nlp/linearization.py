"""Linearisation of the nonlinear program about a trajectory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.trajopt.nlp.decision import Knots, Scaling
from kinolab.trajopt.nlp.path_constraints import LinearInequalities


@dataclass(frozen=True, eq=False)
class Linearization:
    """Constraints and their derivatives at given knots.

    Attributes:
        knots: Linearisation point.
        defects: End of each step minus the next knot, shape (N, nx).
        sensitivities: Derivatives of the step ends in x, u and h, shape (N, nx, nx + nu + 1).
        rows: Linearised inequalities.
        goal_residual: Scaled goal residual, shape (m,).
        goal_jacobian: Its derivative with respect to the final state, shape (m, nx).
    """

    knots: Knots
    defects: Array
    sensitivities: Array
    rows: LinearInequalities
    goal_residual: Array
    goal_jacobian: Array

    def open_defects(self, scaling: Scaling) -> float:
        """Return the 1-norm of all scaled defects."""
        return float(np.abs(self.defects / scaling.x).sum())

    def violation(self, scaling: Scaling) -> float:
        """Return the total constraint violation, scaled."""
        goal = float(np.abs(self.goal_residual).sum())
        return self.rows.violation + goal + self.open_defects(scaling)
