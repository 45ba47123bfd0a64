"""The goal as an OMPL goal region that can be sampled."""

from __future__ import annotations

from typing import Any

import numpy as np
from ompl import base as ob

from kinolab.problem import PlanningTask
from kinolab.problem.goal import SEARCHED_FRACTION
from kinolab.search.ompl.spaces import StateCodec
from kinolab.steering.goal_connection import SteeredGoalConnection


class GoalSamples:
    """Samples around the goal, with randomly scaled tolerances.

    The factor is log-uniform between 1 and ``goal_region_scale``.

    Source: LaValle, Kuffner, Rapidly-exploring random trees: progress and prospects, WAFR 2000,
    where the region shrinks with the tree's distance (RRT-GoalZoom).
    """

    def __init__(
        self, problem: PlanningTask, goal_region_scale: float = 1.0, seed: int = 0
    ) -> None:
        self._problem, self._zoom = problem, goal_region_scale
        self._generator = np.random.default_rng(seed)

    def draw(self) -> list[float]:
        """Sample a state in or around the goal region, in the machine's order."""
        spread = self._zoom ** self._generator.uniform() if self._zoom > 1.0 else 1.0
        values: list[float] = self._problem.sample_goal(self._generator, spread).tolist()
        return values


class GoalRegion(ob.GoalSampleableRegion):  # type: ignore[misc]
    """The goal, with the largest normalised error as its distance.

    A state with a goal connection counts as inside.
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
        self.setThreshold(SEARCHED_FRACTION)

    def distanceGoal(self, state: Any) -> float:
        """Return the normalised goal error of a state; 0 if it has a goal connection."""
        values = self._states.read(state)
        excess = self._problem.goal_excess(np.array(values))
        led = self._last_step and self._last_step.connect(values, excess)
        return 0.0 if led else excess

    def sampleGoal(self, state: Any) -> None:
        """Write a sample in or around the goal region."""
        self._states.write(state, self._samples.draw())

    def maxSampleCount(self) -> int:
        """Return the largest integer: samples never run out."""
        return 2**31 - 1
