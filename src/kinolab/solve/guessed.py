"""Planning again: the search is left out where a motion that is known can be made to fit.

Where: a motion that is a guess.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from kinolab import trajopt
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult
from kinolab.trajectory import Trajectory


@final
@dataclass(frozen=True, kw_only=True)
class GuessedMotion(AbstractPlanner):
    """Makes a known motion begin at the problem's start, end in its goal and meet its limits.

    Attributes:
        guess: A motion of the same machine, from wherever it begins.
    """

    name = "guess"
    hybrid = waits = True

    guess: Trajectory

    def __post_init__(self) -> None:
        """Leave it as it is: it has no settings."""

    def solve(
        self,
        problem: PlanningTask,
        seed: int,  # noqa: ARG002 - nothing is drawn
        budget: Budget,
    ) -> SearchResult:
        """Follow its inputs from the start; make the motion exact where they do not suffice."""
        x = problem.space.continuous(np.vstack([problem.start, self.guess.x]))[1:]
        made = trajopt.make_exact(problem, replace(self.guess, x=x), budget.expired)
        if made is None:
            return SearchResult(Outcome.NOT_FOUND, np.zeros(1), self.guess.inputs[:0], 0)
        return SearchResult(Outcome.SOLVED, made.t, made.inputs, 0)
