"""Potential-field search: build the field, descend it, and escape from its minima."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.search.planner import Budget, Outcome, SearchResult
from kinolab.search.potential.descent import Descent, Ending, PartialMotion
from kinolab.search.potential.fast_sweeping import arrival_times
from kinolab.search.potential.field import Field, Repulsion
from kinolab.search.potential.field_setup import navigation_field, plain_field
from kinolab.search.potential.interruptible import run_unless_cancelled
from kinolab.search.potential.lookahead import Lookahead
from kinolab.search.potential.pullback import InputProjection
from kinolab.search.potential.random_walk_escapes import RandomWalkEscapes
from kinolab.search.result import unsolved
from kinolab.simulation import Propagator
from kinolab.simulation.resimulated_goal import TrueEnds
from kinolab.steering import GoalConnection


@dataclass(frozen=True, kw_only=True)
class FieldSettings:
    """Settings of the search; documented in the planner."""

    navigation: bool
    random_walk_escapes: int
    attractive_gain: float
    damping: float
    repulsive_gain: float
    influence_distance: float
    horizon: float
    control_samples: int
    resolution: float
    grid_memory: float
    clearance_cost_radius: float
    goal_connection_distance: float
    stall_time: float


def solve(
    problem: PlanningTask, settings: FieldSettings, seed: int, budget: Budget
) -> SearchResult:
    """Search for a motion into the goal by descent of a potential field."""
    propagator = Propagator(problem)
    if settings.navigation:
        run_unless_cancelled(_load_solver, lambda: budget.interrupted)
    budget.restart()
    field = _field(propagator, settings, budget)
    if field is None:
        return _result(
            problem, PartialMotion([problem.start]), Ending.BUDGET, budget, propagator, {}
        )
    projection = InputProjection(problem.model, settings.attractive_gain, settings.damping)
    descent = _descent(field, projection, settings, propagator, budget)

    truth = TrueEnds(problem)

    def reaches(trail: PartialMotion) -> bool:
        return truth.excess(_rows(problem, trail)[1]) <= 1.0

    escapes = RandomWalkEscapes(
        field, descent, projection, propagator, settings.random_walk_escapes, reaches
    )
    ending, trail = escapes.search(problem, np.random.default_rng(seed), budget)
    statistics = {"potential_at_start": float(field.potential(problem.start[None])[0])}
    statistics |= {"minima": float(len(escapes.minima)), "escapes": float(escapes.made)}
    statistics |= truth.statistics
    if escapes.minima:
        statistics |= _where(problem, escapes)
    return _result(problem, trail, ending, budget, propagator, statistics)


def _load_solver() -> None:
    """Compile the eikonal solver on a tiny grid: its compilation is not part of the search."""
    arrival_times(np.ones((2, 2)), np.ones(2))


def _field(propagator: Propagator, settings: FieldSettings, budget: Budget) -> Field | None:
    repulsion = Repulsion(settings.repulsive_gain, settings.influence_distance)
    if not settings.navigation:
        return plain_field(propagator.problem, repulsion)
    return navigation_field(
        propagator,
        repulsion,
        resolution=settings.resolution,
        grid_memory=settings.grid_memory,
        clearance_cost_radius=settings.clearance_cost_radius,
        stop=lambda: budget.over,
    )


def _descent(
    field: Field,
    projection: InputProjection,
    settings: FieldSettings,
    propagator: Propagator,
    budget: Budget,
) -> Descent:
    problem = field.problem
    steps = _steps(settings.horizon, problem)
    lookahead = Lookahead(field, projection, steps, settings.control_samples, budget.expired)
    arrival = GoalConnection(problem, steps, propagator, lambda: budget.over)
    patience = _steps(settings.stall_time, problem)
    return Descent(
        field, lookahead, arrival, propagator, settings.goal_connection_distance, patience
    )


def _steps(duration: float, problem: PlanningTask) -> int:
    return max(1, round(min(duration / problem.step, 10_000.0)))


def _rows(problem: PlanningTask, trail: PartialMotion) -> tuple[Array, Array]:
    u = np.array(trail.inputs, dtype=float).reshape(-1, problem.model.nu)
    t: Array = problem.step * np.arange(len(u) + 1.0)
    return t, u


def _where(problem: PlanningTask, escapes: RandomWalkEscapes) -> dict[str, float]:
    """Return the configuration of the lowest minimum, by coordinate names."""
    lowest = min(escapes.minima, key=lambda minimum: minimum.lowest)
    names = problem.model.state_names[: problem.model.nq]
    place = {f"minimum_{n}": float(v) for n, v in zip(names, lowest.place, strict=False)}
    return {"minimum_potential": lowest.lowest, **place}


def _result(
    problem: PlanningTask,
    trail: PartialMotion,
    ending: Ending,
    budget: Budget,
    propagator: Propagator,
    statistics: Mapping[str, float],
) -> SearchResult:
    t, u = _rows(problem, trail)
    rejections = propagator.rejections
    counted = {f"rejected_by_{cause}": float(n) for cause, n in rejections.counts.items()}
    outcome = _outcome(ending, budget, len(u))
    return SearchResult(
        outcome, t, u, budget.iterations, {**counted, **statistics}, rejections.shares()
    )


def _outcome(ending: Ending, budget: Budget, steps: int) -> Outcome:
    if ending is Ending.GOAL:
        return Outcome.SOLVED
    if ending is Ending.MINIMUM:
        return Outcome.LOCAL_MINIMUM
    return unsolved(budget, steps)
