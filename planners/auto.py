"""The planner of scenarios that name none: those that the measurements recommend, in turn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import ClassVar, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from kinolab.cancel import StoppedError
from kinolab.planners.kpiece_fast import KPIECEFast
from kinolab.planners.rrt_fast import RRTFast
from kinolab.problem import Problem
from kinolab.search import Budget, with_default
from kinolab.search.tree import AbstractCompiledPlanner, AbstractGrowth, Aside, Search
from kinolab.trajopt.multistart.multistart import Shots

Array: TypeAlias = NDArray[np.float64]

KNOTS = 80  # of a guess
FIRST = 4000  # iterations of the trees before the first guess: some milliseconds
SHARE = 20.0  # iterations of the trees for every step of a guess
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

    inputs_tried: int = with_default(4, AbstractCompiledPlanner, "inputs_tried")
    goal_zoom: float = with_default(10.0, AbstractCompiledPlanner, "goal_zoom")
    restart_after: int = with_default(10_000, AbstractCompiledPlanner, "restart_after")
    last_step_every: int = with_default(1000, AbstractCompiledPlanner, "last_step_every")

    def asides(self, problem: Problem, seed: int, budget: Budget) -> Sequence[Aside]:
        """Return guesses."""
        return [_Guesses(problem, seed, budget)]

    def growth(self, problem: Problem, search: Search) -> AbstractGrowth:
        """Return what grows the tree."""
        shared = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return _Rounds([member(**shared).growth(problem, search) for member in MEMBERS])


class _Guesses:
    """Guesses that are optimised while the trees grow.

    Args:
        problem: What to plan.
        seed: Of the random numbers.
        budget: Of the search.

    Attributes:
        due: Iterations of the trees until the next guess.
    """

    def __init__(self, problem: Problem, seed: int, budget: Budget) -> None:
        again = math.isfinite(budget.below)  # then every other search begins with a guess
        self.due: float = 1 if again and seed % 2 else FIRST
        self._problem, self._seed, self._budget = problem, seed, budget

    @cached_property
    def _shots(self) -> Shots:
        with self._budget.preparing():
            budget = self._budget
            shots = Shots(self._problem, KNOTS, self._seed, lambda: budget.late, budget.below)
            shots.prepare()
            return shots

    def after(self, iterations: int, tree: AbstractGrowth) -> Array | None:  # noqa: ARG002
        """Return inputs into the goal, where a guess was due and led there."""
        self.due -= iterations
        if self.due > 0:
            return None
        try:
            shot = self._shots.next()
        except StoppedError:
            return None
        self.due = SHARE * shot.steps
        return None if shot.motion is None else shot.motion.u


class _Rounds(AbstractGrowth):
    """Trees of which one grows, and another one from the next beginning on."""

    def __init__(self, trees: Sequence[AbstractGrowth]) -> None:
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
