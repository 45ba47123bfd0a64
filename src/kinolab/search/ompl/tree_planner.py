"""Base classes of OMPL's control-based tree planners."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from functools import partial
from typing import Any

from kinolab.problem import PlanningTask
from kinolab.search.budget import Budget
from kinolab.search.ompl.control_guidance import ControlGuide
from kinolab.search.ompl.control_search import search
from kinolab.search.ompl.simple_setup import OmplSetup
from kinolab.search.planner import AbstractTreeSearch
from kinolab.search.result import SearchResult
from kinolab.settings import setting, with_default
from kinolab.steering.goal_connection import SteeredGoalConnection


@dataclass(frozen=True, kw_only=True)
class AbstractTreePlanner(AbstractTreeSearch):
    """An OMPL control planner that grows a tree from the start."""

    @abstractmethod
    def make(self, setup: OmplSetup) -> Any:
        """Return OMPL's planner."""

    def ompl_setup(
        self, problem: PlanningTask, seed: int, budget: Budget, **guided: Any
    ) -> OmplSetup:
        """Return the problem in OMPL's terms; the seed is for samples that OMPL does not draw.

        Args:
            guided: More arguments of ``OmplSetup``, for motions that are guided.
        """
        return OmplSetup(
            problem,
            min_steps=self.min_steps,
            max_steps=self.max_steps,
            goal_region_scale=self.goal_region_scale,
            seed=seed,
            given_up=lambda: budget.interrupted,
            **guided,
        )

    def begin(self, setup: OmplSetup) -> Any:
        """Return OMPL's planner, ready to solve."""
        planner = self.make(setup)
        planner.setProblemDefinition(setup.problem_definition)
        planner.setup()
        return planner

    def again(self, setup: OmplSetup, planner: Any) -> Any:  # noqa: ARG002
        """Return a planner with an empty tree, given a used one."""
        planner.clear()
        return planner

    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:
        """Grow a tree from the start until it reaches the goal region."""
        setup = self.ompl_setup(problem, seed, budget)
        return search(setup, self.begin, self.again, seed, budget, self.restart_after)


@dataclass(frozen=True, kw_only=True)
class AbstractGuidedPlanner(AbstractTreePlanner):
    """A tree planner that samples inputs at random once it has selected a node.

    OMPL 2.0.1's wheel exposes none of these planners' parameters, not even a goal bias. So
    candidate inputs are compared by lookahead before one is applied.
    """

    goal_region_scale: float = with_default(10.0, AbstractTreePlanner, "goal_region_scale")
    restart_after: int = with_default(40_000, AbstractTreePlanner, "restart_after")
    control_samples: int = setting(
        32, 1, 1000, meaning="Most inputs that are compared before one is held."
    )
    goal_bias: float = setting(
        0.5, 0.0, 1.0, meaning="Probability of growing to the goal from a state near it."
    )
    goal_connection_period: int = setting(
        50,
        0,
        1_000_000,
        unit="states",
        meaning="One of so many states is steered into the goal; 0 for none.",
    )

    def ompl_setup(
        self, problem: PlanningTask, seed: int, budget: Budget, **guided: Any
    ) -> OmplSetup:
        """Return the problem in OMPL's terms, with guided motions."""
        every = self.goal_connection_period
        last_step = (
            SteeredGoalConnection(problem, every, self.goal_region_scale, lambda: budget.over)
            if every
            else None
        )
        samples, bias = self.control_samples, self.goal_bias
        guide = partial(ControlGuide, control_samples=samples, goal_bias=bias)
        return super().ompl_setup(problem, seed, budget, guide=guide, last_step=last_step, **guided)


@dataclass(frozen=True, kw_only=True)
class AbstractGridPlanner(AbstractGuidedPlanner):
    """A tree planner that selects nodes by a grid over the first coordinates."""

    cells: int = setting(20, 1, 1000, meaning="Cells along each coordinate that is divided.")
    angles: bool = setting(
        False, meaning="Whether angles are divided too, where there are fewer than three lengths."
    )

    def ompl_setup(
        self, problem: PlanningTask, seed: int, budget: Budget, **guided: Any
    ) -> OmplSetup:
        """Return the problem in OMPL's terms, with the cells of the grid."""
        guided |= {"cells": self.cells, "angles": self.angles}
        return super().ompl_setup(problem, seed, budget, **guided)
