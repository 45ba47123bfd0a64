"""A problem as equations and inequalities of the knots of a trajectory: multiple shooting.

Source: Bock, Plitt, A multiple shooting algorithm for direct solution of optimal control problems,
IFAC 1984; Malyuta and others, Convex optimization for trajectory generation, IEEE Control Systems
42(5), 2022.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import Problem
from kinolab.simulation.sensitivities import StepSensitivities
from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.nlp.goal_constraint import GoalConstraint
from kinolab.trajopt.nlp.linearization import Linearization
from kinolab.trajopt.nlp.path_constraints import (
    LinearInequalities,
    Samples,
    beginnings,
    samples,
    stack,
)

Array: TypeAlias = NDArray[np.float64]


class Inequalities(Protocol):
    """One kind of margins along a trajectory."""

    @property
    def begins(self) -> bool:
        """Whether they are looked at where steps begin, not on the way from there."""

    def rows(self, at: Samples, reach: float) -> LinearInequalities:
        """Return the linearised margins that a change may use up."""

    def violation(self, at: Samples) -> float:
        """Return the sum of all that is missing."""


class MultipleShooting:
    """The equations of one problem for knots near a guess.

    Args:
        problem: To solve.
        step_map: From knot to knot.
        end: A guess of the last state, shape (nx,): it chooses between turns of the same angle.
        inequalities: What to keep on the way.
        pieces: Into which every step is cut, to look at the inequalities.
    """

    def __init__(
        self,
        problem: Problem,
        step_map: StepSensitivities,
        end: Array,
        inequalities: Sequence[Inequalities],
        pieces: int,
    ) -> None:
        self._map, self._ends, self._scales = step_map, GoalConstraint(problem, end), problem.scales
        self._inequalities, self._pieces = inequalities, pieces

    def linearization(self, knots: Knots, reach: float) -> Linearization:
        """Return the linearisation; ``reach`` is the largest change it will be used for."""
        after, tangents = self._map.linearized(knots.x, knots.u, knots.h)
        rows = stack([part.rows(at, reach) for part, at in self._looks(knots)])
        end = knots.x[-1]
        miss, derivative = self._ends.residual(end), self._ends.jacobian(end)
        return Linearization(knots, after - knots.x[1:], tangents, rows, miss, derivative)

    def violation(self, knots: Knots) -> tuple[float, float, float]:
        """Return the sums of all defects, of what is missing in the goal and in inequalities."""
        after = self._map.after(knots.x, knots.u, knots.h)
        defects = float(np.abs((after - knots.x[1:]) / self._scales).sum())
        short = sum(part.violation(at) for part, at in self._looks(knots))
        return defects, float(np.abs(self._ends.residual(knots.x[-1])).sum()), short

    def _looks(self, knots: Knots) -> Iterator[tuple[Inequalities, Samples]]:
        """Yield each kind of margins with where it is looked at."""
        begin, on_the_way = beginnings(knots), samples(knots, self._pieces)
        for part in self._inequalities:
            yield part, begin if part.begins else on_the_way
