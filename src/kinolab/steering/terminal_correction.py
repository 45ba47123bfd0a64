"""Terminal correction: make a motion end exactly at a state by a least-norm change of inputs."""

from __future__ import annotations

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.rollout import Rollout
from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.steering.maneuver import Maneuver

ARRIVAL_TOLERANCE = 1e-9  # scaled error at which the end is reached


class TerminalCorrection:
    """Newton's method on the end of a motion, with least-norm input changes.

    Inputs are scaled by half their range. Inputs that a correction would drive past a limit are
    fixed there, and the others compensate.

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
        """Return the scaled difference from a reached to a wanted state, shape (nx,)."""
        difference = self._problem.space.difference(reached, wanted)
        return np.where(self._matters, difference / self._problem.scales, 0.0)

    def correct(self, x0: Array, u: Array, x1: Array, *, most: int = 8) -> Maneuver | None:
        """Return a motion from x0 that ends at x1, near the one under given inputs.

        Args:
            x0: Start state, shape (nx,).
            u: Initial inputs, shape (N, nu).
            x1: End state, shape (nx,).
            most: Maximum number of corrections.

        Returns:
            The motion, or None if the end is not reached within input limits.
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
        """Return states and inputs with a smaller terminal error, or None."""
        change, fraction = self._change(u, x, error), 1.0
        if change is None:
            return None
        while fraction >= 1 / 64:  # smallest line-search step of a correction
            tried = np.clip(u + fraction * change, self._lower, self._upper)
            states = self._rollout.follow(x0, tried)
            if states is not None:
                left = self.residual(states[-1], x1)
                if np.linalg.norm(left) < (1 - 0.1 * fraction) * np.linalg.norm(error):
                    return states, tried
            fraction /= 2
        return None

    def _change(self, u: Array, x: Array, error: Array) -> Array | None:
        """Return the least-norm input change (N, nu) that moves the end by ``error`` (nx,).

        None if the sensitivities are not finite.
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
        for _ in range(3):  # rounds of fixing inputs at their limits, per correction
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
        """Project state differences, shape (nx, n), onto the tangents of unit vectors.

        No input changes a unit vector's norm, and rounding errors in it would demand large inputs.
        """
        columns = columns.copy()
        for own in (part.own for part in self._problem.space.spheres):
            columns[own] -= np.outer(x[own], x[own] @ columns[own])
        return columns

    def _end_by_inputs(self, x: Array, u: Array) -> Array:
        """Return the scaled sensitivity of the end to every input, shape (nx, N, nu)."""
        A, B = self._rollout.linearise(x, u)
        gain, onward = np.empty((x.shape[1], len(u), u.shape[1])), np.eye(x.shape[1])
        for k in range(len(u) - 1, -1, -1):
            gain[:, k] = onward @ B[k]
            onward = onward @ A[k]
        scaled = gain * self._range / self._problem.scales[:, None, None]
        return np.where(self._matters[:, None, None], scaled, 0.0)
