"""Stop maneuvers: bring a moving machine to rest."""

from __future__ import annotations

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.rollout import Rollout
from kinolab.steering.maneuver import Maneuver
from kinolab.steering.nearest_equilibrium import nearest_equilibrium
from kinolab.steering.terminal_correction import TerminalCorrection
from kinolab.steering.tracking import TrackingLaw

SPEED_FRACTION = 0.6  # fraction of every velocity that should remain after a braking step
MAX_STEPS = 60  # braking steps at most


class StopManeuver:
    """Brings a machine to rest: by feedback if that stabilises it, else by opposing its velocities.

    Args:
        closing: Terminal correction, to end exactly at rest.
        tracker: Feedback about an equilibrium.
    """

    def __init__(
        self,
        problem: PlanningTask,
        rollout: Rollout,
        closing: TerminalCorrection,
        tracker: TrackingLaw,
    ) -> None:
        self._problem, self._rollout = problem, rollout
        self._closing, self._tracker = closing, tracker
        model = problem.model
        self._speeds = model.speeds
        self._scales = problem.scales[self._speeds]
        lower, upper = model.control_bounds.T
        self._middle, self._half = (lower + upper) / 2, np.maximum((upper - lower) / 2, 1e-12)

    def stop(self, x0: Array) -> Maneuver | None:
        """Return a motion from a state, shape (nx,), to exact rest; None if none is found."""
        rough = self._held(x0) or self._slowed(x0)
        if rough is None:
            return None
        settled = nearest_equilibrium(self._problem, rough.x[-1])
        if settled is None:
            return None
        rest, hold = settled
        # 6 steps appended for the terminal correction to rest
        inputs = np.vstack([rough.u, np.tile(hold, (6, 1))])
        return self._closing.correct(x0, inputs, rest)

    def _held(self, x0: Array) -> Maneuver | None:
        """Return the closed-loop motion about the nearest equilibrium, or None."""
        settled = nearest_equilibrium(self._problem, x0)
        if settled is None:
            return None
        return self._tracker.settle_at(x0, *settled, MAX_STEPS)

    def _slowed(self, x0: Array) -> Maneuver | None:
        """Return the motion under inputs that reduce every velocity step by step, or None."""
        states, inputs = [x0], list[Array]()
        while self._fast(states[-1]) and len(inputs) < MAX_STEPS:
            u = self._against(states[-1])
            reached = self._rollout.follow(states[-1], u[None])
            if reached is None:
                return None
            states.append(reached[1])
            inputs.append(u)
        found = np.array(inputs).reshape(len(inputs), len(self._middle))
        return None if self._fast(states[-1]) else Maneuver(np.array(states), found)

    def _fast(self, x: Array) -> bool:
        # 1e-3: scaled velocity below which terminal correction takes over
        return bool(np.abs(x[self._speeds] / self._scales).max(initial=0.0) > 1e-3)

    def _against(self, x: Array) -> Array:
        """Return inputs (nu,) that best leave SPEED_FRACTION of the velocities after a step."""
        model = self._problem.model
        drift = model.f(x, self._middle)[self._speeds]
        gain = model.jacobian(x, self._middle)[1][self._speeds]
        wanted = -(1.0 - SPEED_FRACTION) * x[self._speeds] / self._rollout.step - drift
        rows = gain * self._half / self._scales[:, None]
        fraction = np.linalg.lstsq(rows, wanted / self._scales, rcond=1e-10)[0]
        # 0.95: fraction of the input range for braking; the correction may need the rest
        largest = max(np.abs(fraction).max(initial=0.0) / 0.95, 1.0)
        return np.asarray(self._middle + self._half * fraction / largest)
