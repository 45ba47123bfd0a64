"""Feedback around a plan: the inputs that were planned, and gains on what the motion is off by.

Source: Tedrake, Underactuated Robotics, 2023, section 8.2 (time-varying LQR).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics import dlqr, tvlqr
from kinolab.dynamics.riccati import NotStabilisableError
from kinolab.optimize.step_map import METHODS, StepMap
from kinolab.problem import Problem
from kinolab.trajectory import Trajectory

Array: TypeAlias = NDArray[np.float64]

OFF = 0.2  # of what [metric] calls large: a deviation from the plan that counts
EFFORT = 0.25  # of the range between an input's limits: a correction that counts as large
ENDING = 10.0  # times the weight of a deviation on the way: one at the end of the plan
FINE = 4  # substeps, where the problem's own integrator cannot be differentiated


@dataclass(frozen=True, eq=False)
class Tracker:
    """Inputs of the model (references, where it has feedback) that keep a machine to its plan.

    Attributes:
        problem: Whose plan it is.
        x: Planned states, shape (N+1, nx).
        u: Planned inputs, shape (N, nu).
        gains: On the deviations, shape (N, nu, nx).
        staying: Gain about the last state, shape (nu, nx).
        limits: Of the inputs, shape (nu, 2): all that the machine can do, [bounds] apart.
    """

    problem: Problem
    x: Array
    u: Array
    gains: Array
    staying: Array
    limits: Array

    @classmethod
    def along(cls, problem: Problem, trajectory: Trajectory) -> Tracker:
        """Design gains along a plan; it must have at least one step."""
        model, settings = problem.whole or problem.model, problem.scenario.integration
        method, substeps = settings.method, settings.substeps
        if method not in METHODS:
            method, substeps = "rk4", FINE
        step = StepMap(model, method, substeps)
        x, u, spans = trajectory.x, trajectory.inputs, np.diff(trajectory.t)
        slopes = [
            step.linearised(x[k : k + 1], u[k : k + 1], float(span))[1][0]
            for k, span in enumerate(spans)
        ]
        table, nx = np.array(slopes), model.nx
        A, B = table[:, :, :nx], table[:, :, nx : nx + model.nu]
        Q = np.diag((problem.weights / OFF) ** 2)
        R = np.diag((EFFORT * np.ptp(model.control_bounds, axis=1)) ** -2.0)
        gains = tvlqr(A, B, Q, R, ENDING * Q)
        return cls(
            problem, x, u, gains, _staying(A[-1], B[-1], Q, R, gains[-1]), model.control_bounds
        )

    def inputs(self, k: int, seen: Array) -> Array:
        """Return the inputs of step k at a measured state, within their limits, shape (nu,).

        After the end of the plan its last inputs and its last state are what is kept to.
        """
        step = min(k, len(self.u) - 1)
        gain = self.gains[step] if k < len(self.u) else self.staying
        off = self.deviation(self.x[min(k, len(self.u))], seen)
        wanted: Array = np.clip(self.u[step] - gain @ off, *self.limits.T)
        return wanted

    def deviation(self, planned: Array, x: Array) -> Array:
        """Return how far a state is from a planned one, shape (nx,); angles on the circle."""
        problem, off = self.problem, x - planned
        wrapped = (off + np.pi) % (2 * np.pi) - np.pi
        off = np.where(problem.circular, wrapped, off)
        for first in problem.model.attitudes.values():
            own = slice(first, first + 4)
            if x[own] @ planned[own] < 0:
                off[own] = -x[own] - planned[own]
        return np.asarray(off)


def _staying(A: Array, B: Array, Q: Array, R: Array, last: Array) -> Array:
    """Return the gain about the last state; the last one of the plan where none is stabilising."""
    try:
        return dlqr(A, B, Q, R)
    except NotStabilisableError:
        return last
