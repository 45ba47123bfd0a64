"""Potential-field planner with navigation functions and random-walk escapes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget, SearchResult, setting
from kinolab.search.potential import FieldSettings, solve


@final
@dataclass(frozen=True, kw_only=True)
class PotentialField(AbstractPlanner):
    """Potential field: follow it down through the full dynamics, escape from minima at random.

    Source: Khatib, IJRR 5(1), 1986; Barraquand, Latombe, IJRR 10(6), 1991.
    """

    name: ClassVar[str] = "potential_field"

    navigation: bool = setting(
        True, meaning="Whether ways around obstacles are known, and not distances alone."
    )
    random_walk_escapes: int = setting(
        1000, 0, meaning="How many random motions out of minima are made before it gives up."
    )
    attractive_gain: float = setting(
        1.0, 0.0, unit="m/s^2", meaning="Acceleration that is asked for where the slope is 1."
    )
    damping: float = setting(
        1.0, 0.0, unit="1/s", meaning="Rate at which velocities fade that nothing pulls."
    )
    repulsive_gain: float = setting(
        1e-3, 0.0, unit="m^3", meaning="Gain of the push off obstacles."
    )
    influence_distance: float = setting(
        0.3, 1e-3, unit="m", meaning="Gap below which obstacles push."
    )
    horizon: float = setting(
        2.0, 0.0, unit="s", meaning="After which time inputs are judged by where they lead."
    )
    control_samples: int = setting(
        6, 0, 1000, meaning="How many random inputs are judged besides those of the field."
    )
    resolution: float = setting(
        0.0, 0.0, unit="m", meaning="Edge of the navigation's cells; 0 takes it from the body."
    )
    grid_memory: float = setting(
        16.0, 0.1, unit="MB", meaning="For the cells of one control point, which grow to fit."
    )
    clearance_cost_radius: float = setting(
        0.5, 0.0, unit="m", meaning="How far from obstacles ways keep where there is room."
    )
    goal_connection_distance: float = setting(
        3.0, 0.0, unit="m", meaning="Length of the way left below which the last motion is sought."
    )
    stall_time: float = setting(
        3.0, 0.0, unit="s", meaning="Time without progress that makes a local minimum."
    )

    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:
        """Descend the field to the goal; escape from minima while escapes are left."""
        settings = FieldSettings(
            **{name: getattr(self, name) for name in FieldSettings.__dataclass_fields__}
        )
        return solve(problem, settings, seed, budget)
