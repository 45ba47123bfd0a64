"""The goal as OMPL sees it."""

from __future__ import annotations

from typing import Any

import numpy as np
from ompl import base as ob

from kinolab.problem import Problem
from kinolab.search.ompl.goal_samples import GoalSamples
from kinolab.search.ompl.spaces import StateCodec
from kinolab.steering.steered_goal_connection import SteeredGoalConnection

# share of the goal's tolerance that counts, so that rounding cannot miss it
TOLERANCE_FRACTION = 0.999


class GoalRegion(ob.GoalSampleableRegion):  # type: ignore[misc]
    """The goal, measured as the largest share of a tolerance that a state deviates.

    A state from which the last step leads into the goal counts as in it.
    """

    def __init__(
        self,
        problem: Problem,
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
