"""Coming to rest from a motion."""

from __future__ import annotations

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.rollout import Rollout
from kinolab.steering.maneuver import Maneuver
from kinolab.steering.nearest_equilibrium import nearest_equilibrium
from kinolab.steering.terminal_correction import TerminalCorrection
from kinolab.steering.tracking import TrackingLaw

SPEED_FRACTION = 0.6  # share of every speed that one step of braking should leave
SLOW_SPEED = 1e-3  # of the speeds' scales, from where the smallest change of inputs ends at rest
MAX_STEPS = 60  # steps
INPUT_FRACTION = 0.95  # share of the inputs' range that braking uses; closing may need the rest
TERMINAL_STEPS = 6  # steps that are added for the end, exactly at rest


class StopManeuver:
    """Brings a machine to rest: by feedback where that holds it, else against its speeds.

    Args:
        problem: Whose machine.
        rollout: Follows inputs.
        closing: Makes the motion end exactly at rest.
        tracker: Knows feedback about an equilibrium.
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
        """Return a motion from a state to one exactly at rest; None where none was found."""
        rough = self._held(x0) or self._slowed(x0)
        if rough is None:
            return None
        settled = nearest_equilibrium(self._problem, rough.x[-1])
        if settled is None:
            return None
        rest, hold = settled
        inputs = np.vstack([rough.u, np.tile(hold, (TERMINAL_STEPS, 1))])
        return self._closing.correct(x0, inputs, rest)

    def _held(self, x0: Array) -> Maneuver | None:
        """Return the motion under feedback about the equilibrium near a state."""
        settled = nearest_equilibrium(self._problem, x0)
        if settled is None:
            return None
        return self._tracker.settle_at(x0, *settled, MAX_STEPS)

    def _slowed(self, x0: Array) -> Maneuver | None:
        """Return the motion under the inputs that take most of every speed, step by step."""
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
        return bool(np.abs(x[self._speeds] / self._scales).max(initial=0.0) > SLOW_SPEED)

    def _against(self, x: Array) -> Array:
        """Return the inputs that leave a share of the speeds after a step, as well as they can."""
        model = self._problem.model
        drift = model.f(x, self._middle)[self._speeds]
        gain = model.jacobian(x, self._middle)[1][self._speeds]
        wanted = -(1.0 - SPEED_FRACTION) * x[self._speeds] / self._rollout.step - drift
        rows = gain * self._half / self._scales[:, None]
        fraction = np.linalg.lstsq(rows, wanted / self._scales, rcond=1e-10)[0]
        largest = max(np.abs(fraction).max(initial=0.0) / INPUT_FRACTION, 1.0)
        return np.asarray(self._middle + self._half * fraction / largest)
