"""Rapidly-exploring random trees, by OMPL."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

from ompl import control as oc

from kinolab.bridge import search
from kinolab.problem import Problem
from kinolab.search import AbstractPlanner, Budget, SearchResult


@final
@dataclass(frozen=True, kw_only=True)
class RRT(AbstractPlanner):
    """Rapidly-exploring random tree over the machine's states (OMPL).

    Source: LaValle, Kuffner, IJRR 20(5), 2001.
    """

    name: ClassVar[str] = "rrt"

    goal_bias: float = 0.05  # probability in [0, 1] of growing toward the goal
    min_steps: int = 1  # propagation steps for which an input is held at least
    max_steps: int = 20  # propagation steps for which an input is held at most

    def solve(self, problem: Problem, seed: int, budget: Budget) -> SearchResult:
        """Grow a tree from the start until it reaches the goal region."""

        def make(space_information: object) -> object:
            planner = oc.RRT(space_information)
            planner.setGoalBias(self.goal_bias)
            return planner

        return search(
            problem, make, seed, budget, min_steps=self.min_steps, max_steps=self.max_steps
        )
