"""kinolab's answer to a problem: a plan, made exact and then shorter until the time is over."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

import kinolab
from kinolab.optimize import repair, shorten
from kinolab.problem import Problem
from kinolab.trajectory import Trajectory

from .records import Improvement

T = TypeVar("T")

OTHER_SEEDS = 1000  # from one try to the next, where a plan could not be made exact
STAGES = ("search", "simulate", "verify")
UNDISTURBED = 0.95  # share of the time left that the optimiser gets, so that it ends within it
FEW = 8  # steps of a motion with which the optimiser is got ready
LOOKS = 3  # after which that is given up


@dataclass
class Found:
    """What a search found.

    Attributes:
        trajectory: The best motion; None where there is none.
        improvements: All that were better than those before.
        setup: Seconds in which planner and optimiser got what they need.
    """

    trajectory: Trajectory | None = None
    improvements: list[Improvement] = field(default_factory=list)
    setup: float = 0.0


def search(
    problem: Problem, strict: Problem, planner: str | None, seed: int, limit: float
) -> Found:
    """Search, repair and shorten within a limit in [s], set-up apart.

    Args:
        problem: As the benchmark states it.
        strict: The same with the goal that exact motions must reach.
        planner: Its name; the usual one where None.
        seed: Of the random numbers.
        limit: Of all stages together, in [s].
    """
    return _Search(problem, strict, limit).run(planner, seed)


class _Search:
    def __init__(self, problem: Problem, strict: Problem, limit: float) -> None:
        self._problem, self._strict, self._limit = problem, strict, limit
        self._spent, self._found = 0.0, Found()

    def run(self, planner: str | None, seed: int) -> Found:
        """Go through all stages; another seed is tried where a plan cannot be made exact."""
        self._get_ready()
        while (given := self._planned(planner, seed)) is not None and not self._optimised(given):
            seed += OTHER_SEEDS
        return self._found

    def _optimised(self, given: Trajectory) -> bool:
        """Make a plan exact and then shorter; say whether it could be made exact."""
        exact = self._timed(lambda: repair(self._problem, given, self._late()))
        if exact is None or not self._kept(exact, "repair"):
            return False
        rest = UNDISTURBED * (self._limit - self._spent)
        self._kept(self._timed(lambda: shorten(self._problem, exact, rest)), "shorten")
        return True

    def _get_ready(self) -> None:
        """Load what is compiled of the optimiser, which counts as set-up."""
        model, problem = self._problem.model, self._problem
        t, x = problem.step * np.arange(FEW + 1.0), np.tile(problem.start, (FEW + 1, 1))
        u = np.tile(model.control_bounds.mean(axis=1), (FEW, 1))
        still = Trajectory(t, x, u, model.state_names, model.control_names)
        asked = iter([False] * LOOKS)
        begun = time.perf_counter()
        repair(problem, still, lambda: next(asked, True))
        self._found.setup += time.perf_counter() - begun

    def _planned(self, planner: str | None, seed: int) -> Trajectory | None:
        left = self._limit - self._spent
        if left <= 0:
            return None
        plan = self._problem.solve(planner, seed=seed, time_limit=left)
        self._found.setup += plan.timings.get("prepare", 0.0)
        self._spent += sum(plan.timings.get(stage, 0.0) for stage in STAGES)
        if plan.status != "solved" or plan.trajectory is None:
            return None
        self._note(plan.trajectory, "search")
        return plan.trajectory

    def _kept(self, trajectory: Trajectory, made_by: str) -> bool:
        """Keep a motion if it passes the strict judgement and is better; say whether it passes."""
        if self._spent > self._limit:
            return False
        passed = self._timed(lambda: kinolab.verify(self._strict, trajectory).passed)
        best = self._found.trajectory
        if passed and (made_by == "repair" or best is None or trajectory.duration < best.duration):
            self._note(trajectory, made_by)
        return passed

    def _note(self, trajectory: Trajectory, made_by: str) -> None:
        self._found.trajectory = trajectory
        one = Improvement(self._spent, trajectory.duration, made_by)
        self._found.improvements.append(one)

    def _timed(self, work: Callable[[], T]) -> T:
        begun = time.perf_counter()
        try:
            return work()
        finally:
            self._spent += time.perf_counter() - begun

    def _late(self) -> Callable[[], bool]:
        end = time.perf_counter() + self._limit - self._spent
        return lambda: time.perf_counter() > end
