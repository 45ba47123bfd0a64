"""States around the goal."""

from __future__ import annotations

import numpy as np

from kinolab.problem import Problem


class GoalSamples:
    """States around the goal, whose tolerances are stretched for each of them.

    The factor is random, log-uniform between 1 and ``goal_region_scale``.

    Source: LaValle, Kuffner, Rapidly-exploring random trees: progress and prospects, WAFR 2000,
    where the region shrinks with the tree's distance (RRT-GoalZoom).
    """

    def __init__(self, problem: Problem, goal_region_scale: float = 1.0, seed: int = 0) -> None:
        self._problem, self._zoom = problem, goal_region_scale
        self._generator = np.random.default_rng(seed)

    def draw(self) -> list[float]:
        """Return a state of the goal region, or of what surrounds it, in the machine's order."""
        spread = self._zoom ** self._generator.uniform() if self._zoom > 1.0 else 1.0
        values: list[float] = self._problem.sample_goal(self._generator, spread).tolist()
        return values
