"""What tree planners have in common whose motions are guided."""

from __future__ import annotations

from dataclasses import dataclass

from kinolab.bridge.bridge import Bridge
from kinolab.bridge.guide import Guidance
from kinolab.bridge.last_step import LastStep
from kinolab.bridge.projection import Grid
from kinolab.bridge.tree_planner import AbstractTreePlanner
from kinolab.problem import Problem
from kinolab.search import setting


@dataclass(frozen=True, kw_only=True)
class AbstractGuidedPlanner(AbstractTreePlanner):
    """A tree planner that leaves the choice of inputs to chance once it knows where to grow.

    OMPL 2.0.1's wheel has none of the settings of these planners, a bias to the goal among them.
    So inputs are compared by where they lead before one is held.
    """

    goal_zoom: float = setting(
        10.0, 1.0, 1e6, unit="tolerances", meaning="How far around the goal growth aims."
    )
    restart_after: int = setting(
        40_000,
        0,
        unit="iterations",
        meaning="When a new tree begins, each lasting 1.5 times as long; 0 for a single one.",
    )
    inputs_tried: int = setting(
        32, 1, 1000, meaning="How many inputs are compared at most before one is held."
    )
    goal_bias: float = setting(
        0.5, 0.0, 1.0, meaning="Probability of growing to the goal from a state near it."
    )

    last_step_every: int = setting(
        50,
        0,
        1_000_000,
        unit="states",
        meaning="From how many states one is steered into the goal; 0 for none.",
    )

    def bridge(self, problem: Problem, seed: int) -> Bridge:
        """Return the problem in OMPL's terms, with guided motions."""
        every = self.last_step_every
        return Bridge(
            problem,
            min_steps=self.min_steps,
            max_steps=self.max_steps,
            goal_zoom=self.goal_zoom,
            seed=seed,
            grid=self.grid(),
            last_step=LastStep(problem, every, self.goal_zoom) if every else None,
            guidance=Guidance(inputs_tried=self.inputs_tried, goal_bias=self.goal_bias),
        )

    def grid(self) -> Grid:
        """Return how the default projection divides a configuration."""
        return Grid()
