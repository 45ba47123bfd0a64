"""Does a motion keep the limits, touch nothing and end in the goal? One judge for both sides."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import PlanningTask
from kinolab.problem.task import LIMIT_TOLERANCE
from kinolab.simulation.machine import states_under

Array: TypeAlias = NDArray[np.float64]


class Judge:
    """Judges motions by their inputs alone, on the problem's own map and by exact FCL.

    Args:
        problem: What they shall solve; its truth is the integrator's own map.
    """

    def __init__(self, problem: PlanningTask) -> None:
        self.problem, self._checker = problem, problem.checker()

    def at_knots(self, u: Array) -> str:
        """Return what is wrong with the states between inputs u (N, nu), as often as OMPL looks.

        Empty where nothing is.
        """
        lower, upper = self.problem.model.control_bounds.T
        if not ((lower - LIMIT_TOLERANCE <= u) & (u <= upper + LIMIT_TOLERANCE)).all():
            return "an input passes its limit"
        states = states_under(self.problem, u)
        fault = self._fault(states, self.problem.step * np.arange(float(len(states))))
        excess = self.problem.goal_excess(states[-1])
        return fault or ("" if excess <= 1.0 else f"it ends {excess:.6g} tolerances from the goal")

    def between(self, u: Array) -> str:
        """Return what is wrong within the steps: at the end of each of their substeps."""
        settings, step = self.problem.scenario.integration, self.problem.step
        states = states_under(self.problem, u)
        for k in range(1, settings.substeps):
            share = k / settings.substeps
            within = self.problem.model.step(
                states[:-1], u, share * step, method=settings.method, substeps=k
            )
            fault = self._fault(within, step * (np.arange(float(len(within))) + share))
            if fault:
                return fault
        return ""

    def _fault(self, states: Array, times: Array) -> str:
        lower, upper = self.problem.bounds.T
        inside = (lower - LIMIT_TOLERANCE <= states) & (states <= upper + LIMIT_TOLERANCE)
        if not inside.all():
            k, i = np.argwhere(~inside)[0]
            name = self.problem.model.state_names[i]
            return f"at t = {times[k]:.6g} s {name} is {states[k, i]:.6g}"
        poses = self.problem.model.frames(states)
        k = self._checker.first_collision(poses)
        if k is None:
            return ""
        named = [f"{c.body} {c.kind} {c.obstacle}" for c in self._checker.contacts(poses[k])]
        return f"at t = {times[k]:.6g} s {(named or ['it collides'])[0]}"
