"""Normalised goal errors one by one, evaluated at every propagation step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.problem.goal_kernel import goal_arrays, state_fractions


class GoalErrors:
    """Deviations of a state from the goal, relative to its tolerances.

    Args:
        reach: Largest normalised error of interest, 1 for the goal region itself.
    """

    def __init__(self, problem: PlanningTask, reach: float) -> None:
        self._problem, self._reach, goal = problem, float(reach), problem.goal
        self._goal, self._x = Record(goal_arrays(goal)), np.zeros(problem.model.nx)
        self._errors = np.zeros(len(goal.indices) + len(goal.parts))
        self._whole = goal.needs_frames or goal.predicate is not None
        self.size = len(self._errors) + self._whole

    def fractions(self, values: Sequence[float]) -> list[float] | None:
        """Return one normalised error per tolerance; None if one of them is out of reach.

        Those of lengths, angles and rates are signed. All others share one.
        """
        self._x[:] = values
        if not state_fractions(self._goal, self._x, self._reach, self._errors):
            return None
        placed = [self._problem.goal_excess(self._x)] if self._whole else []
        near = all(fraction <= self._reach for fraction in placed)
        return [*self._errors.tolist(), *placed] if near else None
