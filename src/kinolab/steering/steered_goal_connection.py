"""The last step into the goal: steered, where a tree of sampled inputs would have to hit it."""

from __future__ import annotations

import numpy as np

from kinolab.cancel import CancellationToken
from kinolab.problem import Problem
from kinolab.simulation import Propagator
from kinolab.steering.goal_connection import GoalConnection

MAX_SHOOTING_STEPS = 20  # steps of the shortest motion that is looked for by shooting


class SteeredGoalConnection:
    """Steers from some of a tree's states into the goal.

    A flat machine is steered from anywhere, others from states near the goal alone: there,
    inputs are looked for by shooting, which goes no way around obstacles.

    Args:
        problem: With the goal.
        every: From how many of the states that could be steered from one is.
        goal_region_scale: What counts as near the goal, in its tolerances.
        stop: Says when looking for motions must end.

    Attributes:
        inputs: That lead into the goal from the state tried last, step by step; empty where none
            were found.
    """

    def __init__(
        self, problem: Problem, every: int, goal_region_scale: float, stop: CancellationToken
    ) -> None:
        self.inputs: list[list[float]] = []
        self._every, self._met = every, 0
        self._within = goal_region_scale if problem.system.flat is None else np.inf
        propagator = Propagator(problem)
        self._arrival = GoalConnection(problem, MAX_SHOOTING_STEPS, propagator, stop, shoots=False)

    def connect(self, values: list[float], excess: float) -> bool:
        """Say whether a state is tried, and a motion into the goal was found.

        Args:
            values: A state that the tree has reached.
            excess: How far outside the goal it is, in tolerances.
        """
        self.inputs = []
        if not 1.0 < excess <= self._within:
            return False
        self._met += 1
        if self._met % self._every:
            return False
        motion = self._arrival.inputs(np.array(values))
        self.inputs = [u.tolist() for u, _ in motion or ()]
        return bool(self.inputs)
