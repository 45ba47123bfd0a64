"""What OMPL's tree planners have in common: how long inputs are held, and rounds."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from kinolab.bridge.bridge import Bridge
from kinolab.bridge.search import search
from kinolab.problem import Problem
from kinolab.search import AbstractPlanner, Budget, SearchResult, setting


@dataclass(frozen=True, kw_only=True)
class AbstractTreePlanner(AbstractPlanner):
    """A control planner of OMPL that grows a tree from the start."""

    min_steps: int = setting(
        1,
        1,
        100_000,
        unit="steps",
        meaning="For how many steps of the integration an input is held at least.",
    )
    max_steps: int = setting(
        20,
        1,
        100_000,
        unit="steps",
        meaning="For how many steps of the integration an input is held at most.",
    )
    goal_zoom: float = setting(
        1.0, 1.0, 1e6, unit="tolerances", meaning="How far around the goal growth aims."
    )
    restart_after: int = setting(
        20_000,
        0,
        unit="iterations",
        meaning="When a new tree begins, each lasting 1.5 times as long; 0 for a single one.",
    )

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

    def conflicts(self) -> Iterator[tuple[str, str, str]]:
        """Yield steps that exclude each other."""
        if self.min_steps > self.max_steps:
            what = f"{self.min_steps} is more than max_steps, {self.max_steps}."
            yield "min_steps", what, "Lower it, or raise max_steps."

    def solve(self, problem: Problem, seed: int, budget: Budget) -> SearchResult:
        """Grow a tree from the start until it reaches the goal region."""
        bridge = self.bridge(problem, seed, budget)
        return search(bridge, self.begin, self.again, seed, budget, self.restart_after)
