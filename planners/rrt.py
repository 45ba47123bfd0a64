"""Rapidly-exploring random trees, by OMPL."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, final

from ompl import control as oc

from kinolab.search import setting
from kinolab.search.ompl import AbstractTreePlanner, OmplSetup


@final
@dataclass(frozen=True, kw_only=True)
class RRT(AbstractTreePlanner):
    """Rapidly-exploring random tree over the machine's states (OMPL).

    Source: LaValle, Kuffner, IJRR 20(5), 2001.
    """

    name: ClassVar[str] = "rrt"

    goal_bias: float = setting(
        0.05, 0.0, 1.0, meaning="Probability of growing toward the goal instead of anywhere."
    )
    intermediate_states: bool = setting(
        False, meaning="Whether every step becomes a node, not only the ends of held inputs."
    )

    def make(self, setup: OmplSetup) -> Any:
        """Return OMPL's planner."""
        planner = oc.RRT(setup.space_information)
        planner.setGoalBias(self.goal_bias)
        planner.setIntermediateStates(self.intermediate_states)
        return planner
