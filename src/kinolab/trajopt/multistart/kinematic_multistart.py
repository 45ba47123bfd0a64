"""Kinematic first, dynamics after: motions of the kinematic reduction as initial guesses.

The reduction has fewer states and no inertia, so shooting finds motions there where it fails with
the whole dynamics. If the inputs accelerate the machine along every velocity that its constraints
leave, it can follow each of them slowly enough.

Source: Bullo, Lynch, Kinematic controllability for decoupled trajectory planning, IEEE Trans.
Robotics and Automation 17(4), 2001.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.problem.machines.kinematic_task import kinematic_task
from kinolab.problem.time_steps import covering_steps
from kinolab.trajectory import Trajectory
from kinolab.trajopt.multistart.guesses import path_time_scaling
from kinolab.trajopt.multistart.multiple_shooting import Multistart, shoot
from kinolab.trajopt.multistart.rest_to_rest import inverse_dynamics
from kinolab.trajopt.nlp.decision import Knots, resampled
from kinolab.trajopt.nlp.options import GUESS


class KinematicMultistart:
    """Multistart in the kinematic reduction, whose motions are guesses for the dynamics.

    Args:
        knots: Approximate number of knots of a guess.
        cancelled: Whether to give up.
        below: Duration in [s] of the incumbent solution, if any.

    Raises:
        InputError: If the machine has no kinematic reduction for this problem.
    """

    def __init__(
        self,
        problem: PlanningTask,
        knots: int,
        seed: int,
        cancelled: Callable[[], bool],
        below: float = math.inf,
    ) -> None:
        self._problem, self._knots, self._cancelled = problem, knots, cancelled
        self._reduced = Multistart(
            kinematic_task(problem), knots, seed, cancelled, below, hasten=False
        )

    def prepare(self) -> None:
        """Warm up: compile and load all that a guess needs."""
        self._reduced.prepare()

    def next(self) -> Trajectory | None:
        """Find a motion of the reduction, from one of several guesses, and solve with the dynamics.

        Returns a motion to the goal's centre, None if that failed.

        Raises:
            CancelledError: If the path search is cancelled.
        """
        reduced = motion = None
        for _ in range(GUESS.kinematic_guesses):
            reduced = self._reduced.next()
            if reduced is not None or self._cancelled():
                break
        if reduced is None:
            return None
        for slower in GUESS.slower_than_kinematic:
            guess, block = self._timed(reduced, slower)
            motion = shoot(
                self._problem, guess, block, GUESS.max_iterations[0], self._cancelled, hasten=False
            )
            if motion is not None or self._cancelled():
                break
        return motion

    def _timed(self, motion: Trajectory, slower: float) -> tuple[Knots, int]:
        """Return a motion of the reduction as a guess, and its steps of the problem per interval.

        Velocities follow the configurations; inputs of least norm, within limits, the velocities.
        """
        problem, duration = self._problem, slower * motion.duration
        count = max(covering_steps(duration, problem.step), GUESS.min_guess_steps)
        block = max(1, round(count / self._knots))
        still = np.zeros((len(motion.x), problem.model.nv))
        none = np.zeros((len(motion.u), problem.model.nu))
        times = slower * (motion.t - motion.t[0])
        even = resampled(
            times, np.hstack([motion.x, still]), none, math.ceil(count / block), problem.space
        )
        guess = path_time_scaling(problem, Knots(even.x, even.u, block * problem.step))
        middle = problem.space.unit((guess.x[1:] + guess.x[:-1]) / 2)
        wanted = np.diff(guess.x[:, problem.model.nq :], axis=0) / guess.h
        inputs = inverse_dynamics(problem, middle, wanted)
        return Knots(guess.x, np.clip(inputs, *problem.model.control_bounds.T), guess.h), block
