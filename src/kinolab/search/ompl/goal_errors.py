"""Normalised goal errors in pure Python: evaluated at every propagation step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.problem import PlanningTask


class GoalErrors:
    """Deviations of a state from the goal, relative to its tolerances.

    Args:
        problem: The planning problem.
        reach: Largest normalised error of interest, 1 for the goal region itself.
    """

    def __init__(self, problem: PlanningTask, reach: float) -> None:
        self._problem, self._reach, goal = problem, reach, problem.goal
        rows = zip(
            goal.indices,
            goal.targets.tolist(),
            goal.tolerances.tolist(),
            goal.circular.tolist(),
            strict=True,
        )
        self._box = list(rows)
        self.size = len(self._box) + len(goal.attitudes) + goal.needs_frames

    def fractions(self, values: Sequence[float]) -> list[float] | None:
        """Return one normalised error per tolerance; None if one of them is out of reach.

        Those of lengths, angles and rates are signed. All points and axes share one.
        """
        found = []
        for index, target, tolerance, circular in self._box:
            deviation = values[index] - target
            if circular:
                deviation = wrapped(deviation)
            fraction = deviation / tolerance
            if not -self._reach <= fraction <= self._reach:
                return None
            found.append(fraction)
        for attitude in self._problem.goal.attitudes:
            fraction = attitude.turn(np.array(values)) / attitude.tolerance
            if not fraction <= self._reach:
                return None
            found.append(fraction)
        if self._problem.goal.needs_frames:
            fraction = self._problem.goal_excess(np.array(values))
            if not fraction <= self._reach:
                return None
            found.append(fraction)
        return found
