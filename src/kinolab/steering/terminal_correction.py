"""Make a motion end exactly where it must, by the smallest change of its inputs."""

from __future__ import annotations

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.rollout import Rollout
from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.steering.maneuver import Maneuver

ARRIVAL_TOLERANCE = 1e-9  # of a state's scale: what counts as having arrived
MAX_ACTIVE_SET_CHANGES = 3  # of fixing inputs that reach their limits, per correction
MIN_STEP_FRACTION = 1 / 64  # of a correction, before it is given up


class TerminalCorrection:
    """Newton's method on the end of a motion, with the inputs of least norm.

    Inputs are measured in half their range. Where a correction would leave the limits, the inputs
    concerned stay there and the others make up for it.

    Source: Bryson, Ho, Applied Optimal Control, 1975, section 7.3 (neighbouring extremals); the
    correction is the least-norm solution of the linearised end condition.
    """

    def __init__(self, problem: PlanningTask, rollout: Rollout) -> None:
        self._problem, self._rollout = problem, rollout
        self._matters = ~cyclic_coordinates(problem)
        lower, upper = problem.model.control_bounds.T
        self._lower, self._upper = lower, upper
        self._range = np.maximum((upper - lower) / 2, 1e-12)

    def residual(self, reached: Array, wanted: Array) -> Array:
        """Return by how much a state is missed, in units of the scales, shape (nx,)."""
        difference = self._problem.space.difference(reached, wanted)
        return np.where(self._matters, difference / self._problem.scales, 0.0)

    def correct(self, x0: Array, u: Array, x1: Array, *, most: int = 8) -> Maneuver | None:
        """Return a motion from x0 that ends at x1, near the one under given inputs.

        Args:
            x0: Beginning, shape (nx,).
            u: Inputs to begin with, shape (N, nu).
            x1: End, shape (nx,).
            most: Corrections that are tried.

        Returns:
            None where the end is not reached within the inputs' limits.
        """
        u = np.clip(u, self._lower, self._upper)
        x = self._rollout.follow(x0, u)
        for _ in range(most):
            if x is None:
                return None
            error = self.residual(x[-1], x1)
            if np.abs(error).max() <= ARRIVAL_TOLERANCE:
                return Maneuver(x, u)
            better = self._corrected(x0, x1, u, x, error)
            if better is None:
                return None
            x, u = better
        arrived = x is not None and np.abs(self.residual(x[-1], x1)).max() <= ARRIVAL_TOLERANCE
        return Maneuver(x, u) if x is not None and arrived else None

    def _corrected(
        self, x0: Array, x1: Array, u: Array, x: Array, error: Array
    ) -> tuple[Array, Array] | None:
        """Return a motion that misses by less."""
        change, fraction = self._change(u, x, error), 1.0
        if change is None:
            return None
        while fraction >= MIN_STEP_FRACTION:
            tried = np.clip(u + fraction * change, self._lower, self._upper)
            states = self._rollout.follow(x0, tried)
            if states is not None:
                left = self.residual(states[-1], x1)
                if np.linalg.norm(left) < (1 - 0.1 * fraction) * np.linalg.norm(error):
                    return states, tried
            fraction /= 2
        return None

    def _change(self, u: Array, x: Array, error: Array) -> Array | None:
        """Return the smallest change of all inputs that moves the end by ``error``.

        None where the motion is so wild that its derivatives are no numbers.
        """
        with np.errstate(all="ignore"):
            gain = self._end_by_inputs(x, u)
        if not np.isfinite(gain).all():
            return None
        rows, total = self._turns(gain.reshape(len(error), -1), x[-1]), np.zeros(u.size)
        error = self._turns(error[:, None], x[-1])[:, 0]
        clearance = np.stack([self._lower - u, self._upper - u]) / self._range
        below, above = clearance[0].ravel(), clearance[1].ravel()
        free = np.ones(u.size, dtype=bool)
        for _ in range(MAX_ACTIVE_SET_CHANGES):
            left = error - rows @ total
            step, *_ = np.linalg.lstsq(rows[:, free], left, rcond=1e-10)
            wanted = total.copy()
            wanted[free] += step
            total = np.clip(wanted, below, above)
            beyond = total != wanted
            if not beyond.any():
                break
            free &= ~beyond
        return np.asarray(total.reshape(u.shape) * self._range)

    def _turns(self, columns: Array, x: Array) -> Array:
        """Return differences of states, shape (nx, n), without any of a quaternion's length.

        No input changes the length, and what rounding leaves of it would ask for large inputs.
        """
        columns = columns.copy()
        for own in self._problem.space.quaternions:
            columns[own] -= np.outer(x[own], x[own] @ columns[own])
        return columns

    def _end_by_inputs(self, x: Array, u: Array) -> Array:
        """Return the derivative of the end by every input, in scaled units, (nx, N, nu)."""
        A, B = self._rollout.linearise(x, u)
        gain, onward = np.empty((x.shape[1], len(u), u.shape[1])), np.eye(x.shape[1])
        for k in range(len(u) - 1, -1, -1):
            gain[:, k] = onward @ B[k]
            onward = onward @ A[k]
        scaled = gain * self._range / self._problem.scales[:, None, None]
        return np.where(self._matters[:, None, None], scaled, 0.0)
