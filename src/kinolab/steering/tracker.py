"""Time-varying LQR along a plan: planned inputs, and gains on deviations.

Source: Tedrake, Underactuated Robotics, 2023, section 8.2 (time-varying LQR).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics import Model, tvlqr
from kinolab.dynamics.codegen.methods import METHODS
from kinolab.dynamics.language.modes import MODE
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.sensitivities import StepSensitivities
from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.trajectory import Trajectory

LARGE_DEVIATION = 0.2  # of one over a state's weight in [metric]: a large deviation


@dataclass(frozen=True, eq=False)
class Tracker:
    """Inputs of the model (references if it has feedback) that track a plan.

    Attributes:
        problem: The problem of the plan.
        x: Planned states, shape (N+1, nx).
        u: Planned inputs, and those that hold the last state, shape (N+1, nu).
        gains: On deviations along the plan, and from its last state, shape (N+1, nu, nx).
        limits: Of the inputs, shape (nu, 2): the machine's own, regardless of [bounds].
        weights: Of deviations, shape (nx,): those of [metric], and 0 for what is not tracked.
    """

    problem: PlanningTask
    x: Array
    u: Array
    gains: Array
    limits: Array
    weights: Array

    @classmethod
    def along(
        cls,
        problem: PlanningTask,
        trajectory: Trajectory,
        *,
        large: float = LARGE_DEVIATION,
        asked: Sequence[str] = (),
    ) -> Tracker:
        """Design gains along a plan.

        Args:
            trajectory: The plan, of at least one step.
            large: The deviation that is worth a large correction, as a fraction of one over each
                state's weight in the metric.
            asked: Names of coordinates that are tracked though nothing depends on them.
        """
        model, settings = problem.whole or problem.model, problem.scenario.integration
        step = StepSensitivities(model, METHODS[settings.method], settings.substeps)
        x, u, spans = trajectory.x, trajectory.inputs, np.diff(trajectory.t)
        u = np.vstack([u, _keeping(model, x[-1], u[-1])])
        slopes = [
            step.linearized(x[k : k + 1], u[k : k + 1], float(span))[1][0]
            for k, span in enumerate([*spans, spans[-1]])
        ]
        table, nx = np.array(slopes), model.nx
        A, B = table[:, :, :nx], table[:, :, nx : nx + model.nu]
        weights = tracked_weights(problem, asked)
        Q = np.diag((weights / large) ** 2)
        # 0.25 of the range between an input's limits: a large correction
        R = np.diag((0.25 * np.ptp(model.control_bounds, axis=1)) ** -2.0)
        # 10.0: weight of a deviation at the plan's end, relative to one along it
        gains = [*tvlqr(A[:-1], B[:-1], Q, R, 10.0 * Q), _staying(A[-1], B[-1], Q, R)]
        return cls(problem, x, u, np.array(gains), model.control_bounds, weights)

    def planned(self, k: int) -> Array:
        """Return the planned inputs of step k, or those that hold the end, shape (nu,)."""
        return np.asarray(self.u[min(k, len(self.u) - 1)])

    def wanted(self, k: int, seen: Array) -> Array:
        """Return the inputs of step k at a measured state, whatever their limits, shape (nu,).

        After the end of the plan its last state is tracked.
        """
        at = min(k, len(self.u) - 1)
        off = self.deviation(self.x[at], seen)
        wanted: Array = self.u[at] - self.gains[at] @ off
        return wanted

    def limited(self, wanted: Array) -> Array:
        """Return inputs (nu,) within their limits."""
        within: Array = np.clip(wanted, *self.limits.T)
        return within

    def deviation(self, planned: Array, x: Array) -> Array:
        """Return the deviation of a state from a planned one, shape (nx,)."""
        return self.problem.space.difference(planned, x)


def tracked_weights(problem: PlanningTask, asked: Sequence[str]) -> Array:
    """Return the weight of each state's entry for tracking, shape (nx,).

    It is 0 for coordinates on which neither the motion nor what may be touched nor the goal
    depends, such as how far a wheel has rolled: bringing them back would cost what does matter.

    Args:
        problem: Machine, world, goal and metric.
        asked: Names of such coordinates that are tracked all the same.
    """
    names = problem.model.state_names
    if problem.machine.modes:  # guards and resets may depend on what the equations do not
        return np.where([name == MODE for name in names], 0.0, problem.weights)
    free = cyclic_coordinates(problem) & [name not in asked for name in names]
    return np.where(free, 0.0, problem.weights)


def _keeping(model: Model, x: Array, u: Array) -> Array:
    """Return the inputs near others that hold a state best (least rate of change), shape (nu,).

    The last inputs of a plan are those that brake it.
    """
    slope = model.jacobian(x, u)[1]
    change = np.linalg.lstsq(slope, model.f(x, u), rcond=None)[0]
    kept: Array = np.clip(u - change, *model.control_bounds.T)
    return kept


def _staying(A: Array, B: Array, Q: Array, R: Array) -> Array:
    """Return the gain about the last state, (nu, nx), over enough steps to converge.

    The algebraic Riccati equation has no solution if an uncontrollable mode does not decay: the
    norm of a quaternion, the angular momentum of a satellite.
    """
    n, (nx, nu) = 1000, B.shape  # steps after the plan over which its end is held
    always, inputs = np.broadcast_to(A, (n, nx, nx)), np.broadcast_to(B, (n, nx, nu))
    return np.asarray(tvlqr(always, inputs, Q, R, Q)[0])
