"""The goal as OMPL sees it."""

from __future__ import annotations

from typing import Any

import numpy as np
from ompl import base as ob

from kinolab.bridge.spaces import States
from kinolab.problem import Problem

INSIDE = 0.999  # share of the goal's tolerance that counts, so that rounding cannot miss it


class GoalRegion(ob.GoalSampleableRegion):  # type: ignore[misc]
    """The goal, measured as the largest share of a tolerance that a state deviates.

    Samples come from around the goal: its tolerances are stretched by a factor that is log-uniform
    between 1 and ``zoom``.

    Source: LaValle, Kuffner, Rapidly-exploring random trees: progress and prospects, WAFR 2000,
    where the region shrinks with the tree's distance (RRT-GoalZoom).
    """

    def __init__(
        self, problem: Problem, states: States, space_information: Any, zoom: float = 1.0
    ) -> None:
        super().__init__(space_information)
        self._problem, self._states, self._zoom = problem, states, zoom
        self._generator = np.random.default_rng(0)
        self.setThreshold(INSIDE)

    def distanceGoal(self, state: Any) -> float:
        """Return how far outside the goal a state is."""
        return self._problem.goal_excess(np.array(self._states.read(state)))

    def sampleGoal(self, state: Any) -> None:
        """Write a state of the goal region, or of what surrounds it."""
        spread = self._zoom ** self._generator.uniform() if self._zoom > 1.0 else 1.0
        self._states.write(state, self._problem.sample_goal(self._generator, spread).tolist())

    def maxSampleCount(self) -> int:
        """Return that there is no end of samples."""
        return 2**31 - 1
