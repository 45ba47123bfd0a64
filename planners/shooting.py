"""Trajectory optimisation by multistart, for machines that swing and fly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from kinolab.concurrency.cancel import CancelledError
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult, setting, unsolved
from kinolab.steering.bounded_curvature import curvature_car
from kinolab.trajopt.multistart.car_curves import CarCurves
from kinolab.trajopt.multistart.driftless import is_driftless
from kinolab.trajopt.multistart.kinematic_multistart import KinematicMultistart
from kinolab.trajopt.multistart.multiple_shooting import Multistart
from kinolab.trajopt.multistart.switching_times import SwitchingTimes


@final
@dataclass(frozen=True, kw_only=True)
class Shooting(AbstractPlanner):
    """Direct multiple shooting from collision-free guesses, straight or winding, fast or slow.

    A guess ignores the dynamics; sequential convex programming turns it into a feasible motion or
    fails. Solutions end exactly in the goal's centre. Of a car of bounded curvature its shortest
    curves are tried first; for a motion shorter than a known one words of extreme inputs, where
    inputs are velocities.

    Source: Bock, Plitt, A multiple shooting algorithm for direct solution of optimal control
    problems, IFAC 1984.
    """

    name: ClassVar[str] = "shooting"
    waits: ClassVar[bool] = True

    knots: int = setting(80, 10, 10_000, meaning="About how many knots a guess has.")

    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:
        """Optimise one guess after another until one succeeds; each is an iteration."""
        given = (seed, budget.expired, budget.below)
        multistart, generator = Multistart(problem, self.knots, *given), [seed, 2]
        first: list[CarCurves | SwitchingTimes] = []
        if (car := curvature_car(problem)) is not None:
            first.append(CarCurves(problem, car, np.random.default_rng(generator), *given[1:]))
        if math.isfinite(budget.below) and is_driftless(problem):
            first.append(SwitchingTimes(problem, np.random.default_rng(generator), *given[1:]))
        return first_motion(problem, multistart, budget, first)


def first_motion(
    problem: PlanningTask,
    multistart: Multistart | KinematicMultistart,
    budget: Budget,
    first: Sequence[CarCurves | SwitchingTimes] = (),
) -> SearchResult:
    """Return the first motion that comes of curves, words or a guess; guesses are iterations."""
    multistart.prepare()
    budget.restart()  # code for this machine was compiled and loaded until here
    motion = None
    try:
        for curves in first:
            motion = motion or curves.next()
        while motion is None and not budget.spent():
            motion = multistart.next()
    except CancelledError:
        budget.take_back()
    if motion is None:
        nothing = np.zeros((0, problem.model.nu))
        return SearchResult(unsolved(budget, 0), np.zeros(1), nothing, budget.iterations)
    return SearchResult(Outcome.SOLVED, motion.t, motion.inputs, budget.iterations)
