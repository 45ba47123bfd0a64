"""Does a motion keep the limits, touch nothing and end in the goal? One judge for both sides."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import ROUNDING, Problem
from kinolab.propagation.compiled_step import CompiledStep

Array: TypeAlias = NDArray[np.float64]


class Judge:
    """Judges motions by their inputs alone, on the problem's own map and by exact FCL.

    Args:
        problem: What they shall solve; its truth is the integrator's own map.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem, self._checker = problem, problem.checker()
        self._step = CompiledStep(problem)

    def at_knots(self, u: Array) -> str:
        """Return what is wrong with the states between inputs u (N, nu), as often as OMPL looks.

        Empty where nothing is.
        """
        lower, upper = self.problem.model.control_bounds.T
        if not ((lower - ROUNDING <= u) & (u <= upper + ROUNDING)).all():
            return "an input passes its limit"
        states = self.knots(u)
        fault = self._fault(states, self.problem.step * np.arange(float(len(states))))
        excess = self.problem.goal_excess(states[-1])
        return fault or ("" if excess <= 1.0 else f"it ends {excess:.6g} tolerances from the goal")

    def between(self, u: Array) -> str:
        """Return what is wrong within the steps: at the end of each of their substeps."""
        settings, step, states = self.problem.scenario.integration, self.problem.step, self.knots(u)
        for k in range(1, settings.substeps):
            share = k / settings.substeps
            within = self.problem.model.step(
                states[:-1], u, share * step, method=settings.method, substeps=k
            )
            fault = self._fault(within, step * (np.arange(float(len(within))) + share))
            if fault:
                return fault
        return ""

    def knots(self, u: Array) -> Array:
        """Return the states (N+1, nx) between inputs, as ``model.step`` would, without its checks.

        NaN from a step on that fails.
        """
        states = np.full((len(u) + 1, self.problem.model.nx), np.nan)
        states[0] = self._step.x[:] = self.problem.start
        for k, held in enumerate(u.tolist()):
            self._step.u[:] = held
            if self._step.step(self.problem.step):
                break
            states[k + 1] = self._step.x[:] = self._step.next[:]
        return states

    def _fault(self, states: Array, times: Array) -> str:
        lower, upper = self.problem.bounds.T
        inside = (lower - ROUNDING <= states) & (states <= upper + ROUNDING)
        if not inside.all():
            k, i = np.argwhere(~inside)[0]
            name = self.problem.model.state_names[i]
            return f"at t = {times[k]:.6g} s {name} is {states[k, i]:.6g}"
        for time, poses in zip(times, self.problem.model.frames(states), strict=True):
            if self._checker.collides(poses):
                contacts = self._checker.contacts(poses)
                named = [f"{c.body} {c.kind} {c.obstacle}" for c in contacts] or ["it collides"]
                return f"at t = {time:.6g} s {named[0]}"
        return ""
