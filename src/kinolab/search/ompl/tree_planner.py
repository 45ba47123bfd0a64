"""What OMPL's tree planners have in common."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any

from kinolab.problem import Problem
from kinolab.search.ompl.control_search import search
from kinolab.search.ompl.simple_setup import Bridge
from kinolab.search.planner import Budget, SearchResult
from kinolab.search.tree_search import AbstractTreeSearch


@dataclass(frozen=True, kw_only=True)
class AbstractTreePlanner(AbstractTreeSearch):
    """A control planner of OMPL that grows a tree from the start."""

    @abstractmethod
    def make(self, bridge: Bridge) -> Any:
        """Return OMPL's planner."""

    def bridge(self, problem: Problem, seed: int, budget: Budget) -> Bridge:  # noqa: ARG002
        """Return the problem in OMPL's terms; the seed is for what OMPL does not draw."""
        return Bridge(
            problem,
            min_steps=self.min_steps,
            max_steps=self.max_steps,
            goal_zoom=self.goal_zoom,
            given_up=lambda: budget.interrupted,
        )

    def begin(self, bridge: Bridge) -> Any:
        """Return OMPL's planner, ready to solve."""
        planner = self.make(bridge)
        planner.setProblemDefinition(bridge.problem_definition)
        planner.setup()
        return planner

    def again(self, bridge: Bridge, planner: Any) -> Any:  # noqa: ARG002
        """Return a planner without a tree, given one that has solved."""
        planner.clear()
        return planner

    def solve(self, problem: Problem, seed: int, budget: Budget) -> SearchResult:
        """Grow a tree from the start until it reaches the goal region."""
        bridge = self.bridge(problem, seed, budget)
        return search(bridge, self.begin, self.again, seed, budget, self.restart_after)
