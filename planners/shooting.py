"""Trajectory optimisation by multistart, for machines that swing and fly."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from kinolab.concurrency.cancel import CancelledError
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult, setting, unsolved
from kinolab.trajopt.multistart.driftless import is_driftless
from kinolab.trajopt.multistart.kinematic_multistart import KinematicMultistart
from kinolab.trajopt.multistart.multiple_shooting import Multistart
from kinolab.trajopt.multistart.switching_times import SwitchingTimes


@final
@dataclass(frozen=True, kw_only=True)
class Shooting(AbstractPlanner):
    """Direct multiple shooting from collision-free guesses, straight or winding, fast or slow.

    A guess ignores the dynamics; sequential convex programming turns it into a feasible motion or
    fails. Solutions end exactly in the goal's centre. For a motion shorter than a known one, words
    of extreme inputs are tried first, where inputs are velocities.

    Source: Bock, Plitt, A multiple shooting algorithm for direct solution of optimal control
    problems, IFAC 1984.
    """

    name: ClassVar[str] = "shooting"

    knots: int = setting(80, 10, 10_000, meaning="About how many knots a guess has.")

    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:
        """Optimise one guess after another until one succeeds; each is an iteration."""
        multistart = Multistart(problem, self.knots, seed, budget.expired, budget.below)
        words = None
        if math.isfinite(budget.below) and is_driftless(problem):
            generator = np.random.default_rng([seed, 2])
            words = SwitchingTimes(problem, generator, budget.expired, budget.below)
        return first_motion(problem, multistart, budget, words)


def first_motion(
    problem: PlanningTask,
    multistart: Multistart | KinematicMultistart,
    budget: Budget,
    words: SwitchingTimes | None = None,
) -> SearchResult:
    """Return the first motion that comes of words or a guess; each guess is an iteration."""
    multistart.prepare()
    budget.restart()  # code for this machine was compiled and loaded until here
    motion = None if words is None else words.next()
    try:
        while motion is None and not budget.spent():
            motion = multistart.next()
    except CancelledError:
        budget.take_back()
    if motion is None:
        nothing = np.zeros((0, problem.model.nu))
        return SearchResult(unsolved(budget, 0), np.zeros(1), nothing, budget.iterations)
    return SearchResult(Outcome.SOLVED, motion.t, motion.inputs, budget.iterations)
