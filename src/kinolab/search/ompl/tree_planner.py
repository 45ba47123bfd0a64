"""What OMPL's tree planners have in common."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any

from kinolab.problem import Problem
from kinolab.search.ompl.control_search import search
from kinolab.search.ompl.simple_setup import OmplSetup
from kinolab.search.planner import AbstractTreeSearch, Budget, SearchResult


@dataclass(frozen=True, kw_only=True)
class AbstractTreePlanner(AbstractTreeSearch):
    """A control planner of OMPL that grows a tree from the start."""

    @abstractmethod
    def make(self, setup: OmplSetup) -> Any:
        """Return OMPL's planner."""

    def ompl_setup(self, problem: Problem, seed: int, budget: Budget) -> OmplSetup:  # noqa: ARG002
        """Return the problem in OMPL's terms; the seed is for what OMPL does not draw."""
        return OmplSetup(
            problem,
            min_steps=self.min_steps,
            max_steps=self.max_steps,
            goal_region_scale=self.goal_region_scale,
            given_up=lambda: budget.interrupted,
        )

    def begin(self, setup: OmplSetup) -> Any:
        """Return OMPL's planner, ready to solve."""
        planner = self.make(setup)
        planner.setProblemDefinition(setup.problem_definition)
        planner.setup()
        return planner

    def again(self, setup: OmplSetup, planner: Any) -> Any:  # noqa: ARG002
        """Return a planner without a tree, given one that has solved."""
        planner.clear()
        return planner

    def solve(self, problem: Problem, seed: int, budget: Budget) -> SearchResult:
        """Grow a tree from the start until it reaches the goal region."""
        setup = self.ompl_setup(problem, seed, budget)
        return search(setup, self.begin, self.again, seed, budget, self.restart_after)
