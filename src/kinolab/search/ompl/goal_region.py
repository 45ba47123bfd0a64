"""The goal as OMPL sees it."""

from __future__ import annotations

from typing import Any

import numpy as np
from ompl import base as ob

from kinolab.problem import PlanningTask
from kinolab.search.ompl.spaces import StateCodec
from kinolab.steering.goal_connection import SteeredGoalConnection


class GoalSamples:
    """States around the goal, whose tolerances are stretched for each of them.

    The factor is random, log-uniform between 1 and ``goal_region_scale``.

    Source: LaValle, Kuffner, Rapidly-exploring random trees: progress and prospects, WAFR 2000,
    where the region shrinks with the tree's distance (RRT-GoalZoom).
    """

    def __init__(
        self, problem: PlanningTask, goal_region_scale: float = 1.0, seed: int = 0
    ) -> None:
        self._problem, self._zoom = problem, goal_region_scale
        self._generator = np.random.default_rng(seed)

    def draw(self) -> list[float]:
        """Return a state of the goal region, or of what surrounds it, in the machine's order."""
        spread = self._zoom ** self._generator.uniform() if self._zoom > 1.0 else 1.0
        values: list[float] = self._problem.sample_goal(self._generator, spread).tolist()
        return values


# share of the goal's tolerance that counts, so that rounding cannot miss it
TOLERANCE_FRACTION = 0.999


class GoalRegion(ob.GoalSampleableRegion):  # type: ignore[misc]
    """The goal, measured as the largest share of a tolerance that a state deviates.

    A state from which the last step leads into the goal counts as in it.
    """

    def __init__(
        self,
        problem: PlanningTask,
        states: StateCodec,
        space_information: Any,
        samples: GoalSamples,
        last_step: SteeredGoalConnection | None,
    ) -> None:
        super().__init__(space_information)
        self._problem, self._states, self._samples = problem, states, samples
        self._last_step = last_step
        self.setThreshold(TOLERANCE_FRACTION)

    def distanceGoal(self, state: Any) -> float:
        """Return how far outside the goal a state is."""
        values = self._states.read(state)
        excess = self._problem.goal_excess(np.array(values))
        led = self._last_step and self._last_step.connect(values, excess)
        return 0.0 if led else excess

    def sampleGoal(self, state: Any) -> None:
        """Write a state of the goal region, or of what surrounds it."""
        self._states.write(state, self._samples.draw())

    def maxSampleCount(self) -> int:
        """Return that there is no end of samples."""
        return 2**31 - 1
