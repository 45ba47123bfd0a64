"""Motions among what stands still, begun later where something that moves is in the way by then.

Source: Kant, Zucker, Toward efficient trajectory planning: the path-velocity decomposition, IJRR
5(3), 1986 (a path among what stands still first, then the time at which it is followed).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.machines.standing import standing
from kinolab.simulation.reference import trajectory_under
from kinolab.steering.nearest_equilibrium import nearest_equilibrium
from kinolab.trajectory import Trajectory
from kinolab.trajopt.exact.exact import make_exact
from kinolab.trajopt.multistart.multiple_shooting import Multistart

DELAYS = (0.0, 0.25, 0.5, 1.0, 2.0)  # of a motion's duration, tried in turn


class VelocityTuning:
    """Guesses for a problem in which something moves.

    Args:
        problem: The planning problem; ``standing`` has one for it.
        knots: Approximate number of knots of a guess.
        cancelled: Whether to give up.
        below: Duration in [s] of the incumbent solution, if any.
    """

    def __init__(
        self,
        problem: PlanningTask,
        knots: int,
        seed: int,
        cancelled: Callable[[], bool],
        below: float,
    ) -> None:
        still = standing(problem)
        assert still is not None
        self._problem, self._cancelled, self._below = problem, cancelled, below
        self._among_standing = Multistart(still, knots, seed, cancelled, below)
        self._guesses: list[Trajectory] = []

    def prepare(self) -> None:
        """Load compiled code."""
        self._among_standing.prepare()

    def next(self) -> Trajectory | None:
        """Return a motion that comes of the next guess; None if none does."""
        if not self._guesses:
            motion = self._among_standing.next()
            if motion is None:
                return None
            self._guesses = [g for d in DELAYS if (g := self._later(motion, d)) is not None]
        guess = self._guesses.pop(0)
        made = make_exact(self._problem, guess, self._cancelled)
        return made if made is not None and made.duration < self._below else None

    def _later(self, motion: Trajectory, delay: float) -> Trajectory | None:
        """Return a motion that begins later, by a fraction of its duration; None if it cannot."""
        problem, (clock,) = self._problem, self._problem.model.clocks
        steps = round(delay * motion.duration / problem.step)
        t, x, inputs = motion.t, motion.x, motion.inputs
        if steps:
            held = nearest_equilibrium(problem, problem.start)
            if held is None or self._moved(held[0]):
                return None
            ahead = problem.step * np.arange(steps)
            t = np.concatenate([ahead, t + steps * problem.step])
            x = np.vstack([np.tile(x[0], (steps, 1)), x])
            inputs = np.vstack([np.tile(held[1], (steps, 1)), inputs])
        x = np.insert(x, clock, problem.start[clock] + t, axis=1)
        return trajectory_under(problem.model, t, x, inputs)

    def _moved(self, x: Array) -> bool:
        problem = self._problem
        away = np.abs(problem.space.difference(problem.start, x)) / problem.scales
        return bool(away.max() > 1e-9)  # of a state's scale: the start itself is held
