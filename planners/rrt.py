"""Rapidly-exploring random trees, by OMPL."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, final

from ompl import control as oc

from kinolab.bridge import search
from kinolab.problem import Problem
from kinolab.search import AbstractPlanner, Budget, SearchResult, setting


@final
@dataclass(frozen=True, kw_only=True)
class RRT(AbstractPlanner):
    """Rapidly-exploring random tree over the machine's states (OMPL).

    Source: LaValle, Kuffner, IJRR 20(5), 2001.
    """

    name: ClassVar[str] = "rrt"

    goal_bias: float = setting(0.05, 0.0, 1.0)  # probability of growing toward the goal
    goal_zoom: float = setting(
        1.0, 1.0, 1e6
    )  # how far around the goal that growth aims, in tolerances
    min_steps: int = setting(1, 1, 100_000)  # propagation steps for which an input is held at least
    max_steps: int = setting(20, 1, 100_000)  # propagation steps for which an input is held at most
    intermediate_states: bool = setting(False)  # whether every propagation step becomes a node
    restart_after: int = setting(20_000, 0)  # iterations before a new tree, then 1.5 times as many

    def conflicts(self) -> Iterator[tuple[str, str, str]]:
        """Yield steps that exclude each other."""
        if self.min_steps > self.max_steps:
            what = f"{self.min_steps} is more than max_steps, {self.max_steps}."
            yield "min_steps", what, "Lower it, or raise max_steps."

    def solve(self, problem: Problem, seed: int, budget: Budget) -> SearchResult:
        """Grow a tree from the start until it reaches the goal region."""

        def make(space_information: object) -> object:
            planner = oc.RRT(space_information)
            planner.setGoalBias(self.goal_bias)
            planner.setIntermediateStates(self.intermediate_states)
            return planner

        return search(
            problem,
            make,
            seed,
            budget,
            min_steps=self.min_steps,
            max_steps=self.max_steps,
            goal_zoom=self.goal_zoom,
            restart_after=self.restart_after,
        )
