"""LQR feedback: about an equilibrium, and time-varying along a motion."""

from __future__ import annotations

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.riccati import NotStabilisableError, dlqr
from kinolab.problem import PlanningTask
from kinolab.simulation.rollout import Rollout
from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.steering.maneuver import Maneuver
from kinolab.steering.terminal_correction import TerminalCorrection

TERMINAL_WEIGHT = 10.0  # of the final state relative to intermediate states
CONTROL_WEIGHT = 1.0  # of a full input relative to a state error of its scale


class TrackingLaw:
    """Discrete-time linear-quadratic regulator with zero-order-hold inputs.

    States are weighted by their scales, inputs by half their range.

    Source: Anderson, Moore, Optimal Control: Linear Quadratic Methods, 1990, chapters 2 and 3.
    """

    def __init__(self, problem: PlanningTask, rollout: Rollout) -> None:
        self._problem, self._rollout = problem, rollout
        self._closing = TerminalCorrection(problem, rollout)
        self._matters = ~cyclic_coordinates(problem)
        self._lower, self._upper = problem.model.control_bounds.T
        half = np.maximum((self._upper - self._lower) / 2, 1e-12)
        self._Q = np.diag(self._matters / problem.scales**2)
        self._R = CONTROL_WEIGHT * np.diag(1.0 / half**2)

    def hold(self, x: Array, u: Array) -> Array | None:
        """Return the gain K of u = u_eq - K (x - x_eq) about an equilibrium, shape (nu, nx).

        None if it is not stabilisable by linear feedback, as for cars, which do not slip sideways.

        Args:
            x: The equilibrium, shape (nx,).
            u: Its inputs, shape (nu,).
        """
        A, B = self._rollout.linearise(np.stack([x, x]), u[None])
        keep = np.flatnonzero(self._matters)
        a, b = A[0][np.ix_(keep, keep)], B[0][keep]
        K = np.zeros((len(u), len(x)))
        try:
            K[:, keep] = dlqr(a, b, self._Q[np.ix_(keep, keep)], self._R)
        except NotStabilisableError:
            return None
        if np.abs(np.linalg.eigvals(a - b @ K[:, keep])).max() >= 1.0:
            return None
        return K

    def gains(self, motion: Maneuver) -> Array:
        """Return time-varying gains along a motion, shape (N, nu, nx), by the Riccati recursion."""
        A, B = self._rollout.linearise(motion.x, motion.u)
        P, gains = (
            TERMINAL_WEIGHT * self._Q,
            np.empty((motion.steps, motion.u.shape[1], motion.x.shape[1])),
        )
        for k in range(motion.steps - 1, -1, -1):
            a, b = A[k] * self._matters[:, None] * self._matters, B[k] * self._matters[:, None]
            gains[k] = np.linalg.solve(self._R + b.T @ P @ b, b.T @ P @ a)
            P = self._Q + a.T @ P @ (a - b @ gains[k])
        return gains

    def track(self, x0: Array, motion: Maneuver, gains: Array | None = None) -> Maneuver | None:
        """Track a motion by feedback from another start; None if the simulation diverges.

        Args:
            x0: Start state, shape (nx,).
            motion: Reference motion.
            gains: Feedback gains, shape (N, nu, nx); those of ``gains`` when left out.
        """
        gains = self.gains(motion) if gains is None else gains
        states, inputs = [x0], []
        for k, (wanted, held) in enumerate(zip(motion.x[:-1], motion.u, strict=True)):
            off = self._closing.residual(states[-1], wanted) * self._problem.scales
            u = np.clip(held + gains[k] @ off, self._lower, self._upper)
            reached = self._rollout.follow(states[-1], u[None])
            if reached is None:
                return None
            states.append(reached[1])
            inputs.append(u)
        return Maneuver(np.array(states), np.array(inputs).reshape(len(inputs), -1))

    def settle_at(self, x0: Array, x1: Array, u1: Array, steps: int) -> Maneuver | None:
        """Return the closed-loop motion from x0 (nx,) about an equilibrium; None if unstable."""
        gain = self.hold(x1, u1)
        if gain is None:
            return None
        still = Maneuver(np.tile(x1, (steps + 1, 1)), np.tile(u1, (steps, 1)))
        return self.track(x0, still, np.tile(gain, (steps, 1, 1)))
