"""The planner of scenarios that name none: those that the measurements recommend, in turn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import ClassVar, final

from kinolab.cancel import CancelledError
from kinolab.numerics.arrays import Array
from kinolab.planners.kpiece_fast import KPIECEFast
from kinolab.planners.rrt_fast import RRTFast
from kinolab.problem import PlanningTask
from kinolab.search import Budget, with_default
from kinolab.search.tree import (
    AbstractCompiledPlanner,
    AbstractTreeExtension,
    SearchState,
    SubSearch,
)
from kinolab.trajopt.multistart.multiple_shooting import Multistart

GUESS_KNOTS = 80  # of a guess
# iterations of the trees before the first guess: some milliseconds
ITERATIONS_BEFORE_GUESSES = 4000
ITERATIONS_PER_GUESS_STEP = 20.0  # iterations of the trees for every step of a guess
MEMBERS: tuple[type[AbstractCompiledPlanner], ...] = (KPIECEFast, RRTFast)


@final
@dataclass(frozen=True, kw_only=True)
class Auto(AbstractCompiledPlanner):
    """A portfolio: rounds of kpiece_fast and of rrt_fast in turn, beside guesses of shooting.

    The first solves nearly everything that we measure; the second is not led astray by cells;
    guesses that are optimised solve what swings and flies.

    Source: Gomes, Selman, Algorithm portfolios, Artificial Intelligence 126(1-2), 2001.
    """

    name: ClassVar[str] = "auto"

    control_samples: int = with_default(4, AbstractCompiledPlanner, "control_samples")
    goal_region_scale: float = with_default(10.0, AbstractCompiledPlanner, "goal_region_scale")
    restart_after: int = with_default(10_000, AbstractCompiledPlanner, "restart_after")
    goal_connection_period: int = with_default(
        1000, AbstractCompiledPlanner, "goal_connection_period"
    )

    def sub_searches(self, problem: PlanningTask, seed: int, budget: Budget) -> Sequence[SubSearch]:
        """Return guesses."""
        return [_Multistart(problem, seed, budget)]

    def extension(self, problem: PlanningTask, search: SearchState) -> AbstractTreeExtension:
        """Return what grows the tree."""
        shared = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return _Portfolio([member(**shared).extension(problem, search) for member in MEMBERS])


class _Multistart:
    """Guesses that are optimised while the trees grow.

    Args:
        problem: What to plan.
        seed: Of the random numbers.
        budget: Of the search.

    Attributes:
        due: Iterations of the trees until the next guess.
    """

    def __init__(self, problem: PlanningTask, seed: int, budget: Budget) -> None:
        again = math.isfinite(budget.below)  # then every other search begins with a guess
        self.due: float = 1 if again and seed % 2 else ITERATIONS_BEFORE_GUESSES
        self._problem, self._seed, self._budget = problem, seed, budget

    @cached_property
    def _multistart(self) -> Multistart:
        with self._budget.preparing():
            budget = self._budget
            multistart = Multistart(
                self._problem, GUESS_KNOTS, self._seed, budget.expired, budget.below
            )
            multistart.prepare()
            return multistart

    def advance(self, iterations: int, tree: AbstractTreeExtension) -> Array | None:  # noqa: ARG002
        """Return inputs into the goal, where a guess was due and led there."""
        self.due -= iterations
        if self.due > 0:
            return None
        try:
            guess = self._multistart.next()
        except CancelledError:
            return None
        self.due = ITERATIONS_PER_GUESS_STEP * guess.steps
        return None if guess.motion is None else guess.motion.u


class _Portfolio(AbstractTreeExtension):
    """Trees of which one grows, and another one from the next beginning on."""

    def __init__(self, trees: Sequence[AbstractTreeExtension]) -> None:
        self._trees, self._turn = trees, -1

    def begin(self) -> None:
        """Begin the next tree."""
        if self._turn < 0:
            for tree in self._trees:  # all are compiled before the clock starts
                tree.begin()
                tree.grow(0)
        self._turn += 1
        self._now = self._trees[self._turn % len(self._trees)]
        self._now.begin()
        self.nodes, self.best = self._now.nodes, self._now.best

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow by some iterations."""
        return self._now.grow(iterations)
