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
    """Potential field: followed downhill through the dynamics, with random escapes from minima.

    Source: Khatib, IJRR 5(1), 1986; Barraquand, Latombe, IJRR 10(6), 1991.
    """

    name: ClassVar[str] = "potential_field"
    work_per_iteration: ClassVar[float] = 1.5e-2

    navigation: bool = setting(
        True,
        meaning="Whether to follow a navigation function around obstacles, not distances alone.",
    )
    random_walk_escapes: int = setting(
        1000, 0, meaning="Random walks out of minima before the search gives up."
    )
    attractive_gain: float = setting(
        1.0, 0.0, unit="m/s^2", meaning="Acceleration asked for where the slope of the field is 1."
    )
    damping: float = setting(
        1.0,
        0.0,
        unit="1/s",
        meaning="Rate at which velocities decay that the field does not ask for.",
    )
    repulsive_gain: float = setting(
        1e-3, 0.0, unit="m^3", meaning="Gain of the repulsion from obstacles."
    )
    influence_distance: float = setting(
        0.3, 1e-3, unit="m", meaning="Clearance below which obstacles repel."
    )
    horizon: float = setting(
        2.0, 0.0, unit="s", meaning="Time after which inputs are compared by where they lead."
    )
    control_samples: int = setting(
        6, 0, 1000, meaning="Random inputs that are compared besides those of the field."
    )
    resolution: float = setting(
        0.0,
        0.0,
        unit="m",
        meaning="Size of the navigation function's cells; 0 derives it from the body.",
    )
    grid_memory: float = setting(
        16.0,
        0.1,
        unit="MB",
        meaning="Memory for the cells of one control point, which grow to fit.",
    )
    clearance_cost_radius: float = setting(
        0.5, 0.0, unit="m", meaning="Clearance that paths prefer where there is space."
    )
    goal_connection_distance: float = setting(
        3.0,
        0.0,
        unit="m",
        meaning="Remaining path length below which a connection to the goal is tried.",
    )
    stall_time: float = setting(
        3.0, 0.0, unit="s", meaning="Time without progress that counts as a local minimum."
    )

    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:
        """Descend the field to the goal; escape from minima while escapes are left."""
        settings = FieldSettings(
            **{name: getattr(self, name) for name in FieldSettings.__dataclass_fields__}
        )
        return solve(problem, settings, seed, budget)
