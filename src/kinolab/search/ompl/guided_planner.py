"""What tree planners have in common whose motions are guided."""

from __future__ import annotations

from dataclasses import dataclass

from kinolab.problem import Problem
from kinolab.search.ompl.control_guidance import Guidance
from kinolab.search.ompl.projection import CellDivision
from kinolab.search.ompl.simple_setup import OmplSetup
from kinolab.search.ompl.tree_planner import AbstractTreePlanner
from kinolab.search.planner import Budget, setting, with_default
from kinolab.steering.steered_goal_connection import SteeredGoalConnection


@dataclass(frozen=True, kw_only=True)
class AbstractGuidedPlanner(AbstractTreePlanner):
    """A tree planner that leaves the choice of inputs to chance once it knows where to grow.

    OMPL 2.0.1's wheel has none of the settings of these planners, a bias to the goal among them.
    So inputs are compared by where they lead before one is held.
    """

    goal_region_scale: float = with_default(10.0, AbstractTreePlanner, "goal_region_scale")
    restart_after: int = with_default(40_000, AbstractTreePlanner, "restart_after")
    control_samples: int = setting(
        32, 1, 1000, meaning="How many inputs are compared at most before one is held."
    )
    goal_bias: float = setting(
        0.5, 0.0, 1.0, meaning="Probability of growing to the goal from a state near it."
    )
    goal_connection_period: int = setting(
        50,
        0,
        1_000_000,
        unit="states",
        meaning="From how many states one is steered into the goal; 0 for none.",
    )

    def ompl_setup(self, problem: Problem, seed: int, budget: Budget) -> OmplSetup:
        """Return the problem in OMPL's terms, with guided motions."""
        return OmplSetup(
            problem,
            min_steps=self.min_steps,
            max_steps=self.max_steps,
            goal_region_scale=self.goal_region_scale,
            seed=seed,
            grid=self.grid(),
            guidance=Guidance(control_samples=self.control_samples, goal_bias=self.goal_bias),
            last_step=self._last_step(problem, budget),
            given_up=lambda: budget.interrupted,
        )

    def _last_step(self, problem: Problem, budget: Budget) -> SteeredGoalConnection | None:
        every = self.goal_connection_period
        return (
            SteeredGoalConnection(problem, every, self.goal_region_scale, lambda: budget.over)
            if every
            else None
        )

    def grid(self) -> CellDivision:
        """Return how the default projection divides a configuration."""
        return CellDivision()
