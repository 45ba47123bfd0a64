"""The last step into the goal: steered, where a tree of sampled inputs would have to hit it."""

from __future__ import annotations

import numpy as np

from kinolab.cancel import Stop
from kinolab.problem import Problem
from kinolab.simulation import Propagator
from kinolab.steering.goal_connection import Arrival

HORIZON = 20  # steps of the shortest motion that is looked for by shooting


class LastStep:
    """Steers from some of a tree's states into the goal.

    A flat machine is steered from anywhere, others from states near the goal alone: there,
    inputs are looked for by shooting, which goes no way around obstacles.

    Args:
        problem: With the goal.
        every: From how many of the states that could be steered from one is.
        zoom: What counts as near the goal, in its tolerances.
        stop: Says when looking for motions must end.

    Attributes:
        inputs: That lead into the goal from the state tried last, step by step; empty where none
            were found.
    """

    def __init__(self, problem: Problem, every: int, zoom: float, stop: Stop) -> None:
        self.inputs: list[list[float]] = []
        self._every, self._met = every, 0
        self._within = zoom if problem.system.flat is None else np.inf
        propagator = Propagator(problem)
        self._arrival = Arrival(problem, HORIZON, propagator, stop, shoots=False)

    def leads_in(self, values: list[float], excess: float) -> bool:
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
