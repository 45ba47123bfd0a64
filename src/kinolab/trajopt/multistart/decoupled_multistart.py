"""Decoupled motions as initial guesses: along one decoupling field at a time, with stops between.

A machine with fewer inputs than velocities can follow its decoupling vector fields with any time
scaling, so that a path along them becomes a motion; friction, which they leave out, and steps in
which inputs are held are up to the optimisation that follows.

Source: Bullo, Lynch, Kinematic controllability for decoupled trajectory planning, IEEE Trans.
Robotics and Automation 17(4), 2001.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.problem.kinematic_task import decoupled_model
from kinolab.trajectory import Trajectory
from kinolab.trajopt.multistart.decoupled_paths import DecoupledPaths, Leg
from kinolab.trajopt.multistart.multiple_shooting import shot
from kinolab.trajopt.multistart.rest_to_rest import LegCurve, timed
from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.options import FIELDS


class DecoupledMultistart:
    """Multistart over random paths along the decoupling fields of a machine.

    Args:
        problem: The planning problem.
        seed: Random seed.
        cancelled: Whether to give up.
        below: Duration in [s] of the incumbent solution, if any.

    Raises:
        InputError: If the machine has no decoupling fields, or moves at the start or in the goal.
    """

    def __init__(
        self,
        problem: PlanningTask,
        seed: int,
        cancelled: Callable[[], bool],
        below: float = math.inf,
    ) -> None:
        self._problem, self._cancelled, self._below = problem, cancelled, below
        self._reduction = decoupled_model(problem)
        generator = np.random.default_rng([seed, 2])
        self._paths = DecoupledPaths(problem, self._reduction, generator, cancelled)

    def prepare(self) -> None:
        """Warm up: compile and load all that a guess needs."""
        legs = [Leg(k, 1e-3) for k in range(self._reduction.nu)]
        self._guess(legs)

    def next(self) -> Trajectory | None:
        """Find a path and solve with the dynamics from there.

        Returns a motion to the goal's centre, None if that failed.

        Raises:
            CancelledError: If the path search is cancelled.
        """
        legs = self._paths.find()
        guess = None if legs is None else self._guess(legs)
        if guess is None or guess.duration >= FIELDS.longer * self._below:
            return None
        return shot(self._problem, guess, 1, FIELDS.max_iterations, self._cancelled, hasten=False)

    def _guess(self, legs: Sequence[Leg]) -> Knots | None:
        """Return the motion along legs, as if there were no friction but the inputs' own."""
        nq, parts = self._problem.model.nq, []
        q = self._problem.start[:nq]
        for leg in legs:
            way = self._paths.configurations(q, leg)
            rates = leg.length * self._paths.rates(way, leg.field)
            part = timed(self._problem, LegCurve.through(self._problem, way, rates))
            if part is None:
                return None
            parts.append(part)
            q = way[-1]
        x = np.vstack([parts[0].x[:1], *(part.x[1:] for part in parts)])
        return Knots(x, np.vstack([part.u for part in parts]), parts[0].h)
