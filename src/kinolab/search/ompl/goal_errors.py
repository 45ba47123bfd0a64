"""Normalised goal errors in pure Python: evaluated at every propagation step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

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
        self.size = len(self._box) + len(goal.parts) + goal.needs_frames

    def fractions(self, values: Sequence[float]) -> list[float] | None:
        """Return one normalised error per tolerance; None if one of them is out of reach.

        Those of lengths, angles and rates are signed. All points and axes share one.
        """
        found = []
        for fraction in self._each(values):
            if not -self._reach <= fraction <= self._reach:
                return None
            found.append(fraction)
        return found

    def _each(self, values: Sequence[float]) -> Iterator[float]:
        for index, target, tolerance, circular in self._box:
            deviation = values[index] - target
            yield (wrapped(deviation) if circular else deviation) / tolerance
        for one in self._problem.goal.parts:
            yield one.error(np.array(values)) / one.tolerance
        if self._problem.goal.needs_frames:
            yield self._problem.goal_excess(np.array(values))
