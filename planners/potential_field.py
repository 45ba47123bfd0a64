"""Potential-field planner with navigation functions and random-walk escapes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult, setting, unsolved
from kinolab.search.potential.descent import Descent, Ending, PartialMotion
from kinolab.search.potential.fast_sweeping import arrival_times
from kinolab.search.potential.field import Field, Repulsion
from kinolab.search.potential.field_setup import navigation_field, plain_field
from kinolab.search.potential.interruptible import run_unless_cancelled
from kinolab.search.potential.lookahead import Lookahead
from kinolab.search.potential.pullback import InputProjection
from kinolab.search.potential.random_walk_escapes import RandomWalkEscapes
from kinolab.simulation import Propagator
from kinolab.simulation.resimulated_goal import TrueEnds
from kinolab.steering import GoalConnection


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
        propagator, truth = Propagator(problem), TrueEnds(problem)
        if self.navigation:  # compiled on a tiny grid: that is not part of the search
            run_unless_cancelled(
                lambda: arrival_times(np.ones((2, 2)), np.ones(2)), lambda: budget.interrupted
            )
        budget.restart()
        field = self._field(propagator, budget)
        if field is None:
            return _result(PartialMotion([problem.start]), Ending.BUDGET, budget, propagator, {})
        projection = InputProjection(problem.model, self.attractive_gain, self.damping)
        steps, patience = (
            max(1, round(min(duration / problem.step, 10_000.0)))
            for duration in (self.horizon, self.stall_time)
        )
        lookahead = Lookahead(field, projection, steps, self.control_samples, budget.expired)
        arrival = GoalConnection(problem, steps, propagator, lambda: budget.over)
        near = self.goal_connection_distance
        descent = Descent(field, lookahead, arrival, propagator, near, patience)
        escapes = RandomWalkEscapes(
            field,
            descent,
            projection,
            propagator,
            self.random_walk_escapes,
            lambda trail: truth.excess(trail.rows(problem.model.nu)) <= 1.0,
        )
        ending, trail = escapes.search(problem, np.random.default_rng(seed), budget)
        statistics = {"potential_at_start": float(field.potential(problem.start[None])[0])}
        statistics |= escapes.statistics(problem) | truth.statistics
        return _result(trail, ending, budget, propagator, statistics)

    def _field(self, propagator: Propagator, budget: Budget) -> Field | None:
        repulsion = Repulsion(self.repulsive_gain, self.influence_distance)
        if not self.navigation:
            return plain_field(propagator.problem, repulsion)
        return navigation_field(
            propagator,
            repulsion,
            resolution=self.resolution,
            grid_memory=self.grid_memory,
            clearance_cost_radius=self.clearance_cost_radius,
            stop=lambda: budget.over,
        )


def _result(
    trail: PartialMotion,
    ending: Ending,
    budget: Budget,
    propagator: Propagator,
    statistics: Mapping[str, float],
) -> SearchResult:
    problem, rejections = propagator.problem, propagator.rejections
    u = trail.rows(problem.model.nu)
    counted = {f"rejected_by_{cause}": float(n) for cause, n in rejections.counts.items()}
    ended = {Ending.GOAL: Outcome.SOLVED, Ending.MINIMUM: Outcome.LOCAL_MINIMUM}
    return SearchResult(
        ended.get(ending) or unsolved(budget, len(u)),
        problem.step * np.arange(len(u) + 1.0),
        u,
        budget.iterations,
        {**counted, **statistics},
        rejections.shares(),
    )
