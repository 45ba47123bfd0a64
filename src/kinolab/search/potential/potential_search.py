"""The whole search: build the field, follow it, escape from its minima, say how it ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import Problem
from kinolab.search.planner import Budget, Outcome, SearchResult
from kinolab.search.potential.descent import Descent, Ending
from kinolab.search.potential.eikonal import shortest
from kinolab.search.potential.field import Field
from kinolab.search.potential.field_setup import navigation_field, plain_field
from kinolab.search.potential.interruptible import unless_stopped
from kinolab.search.potential.lookahead import Lookahead
from kinolab.search.potential.partial_motion import Trail
from kinolab.search.potential.pullback import Projection
from kinolab.search.potential.random_walk_escapes import Escapes
from kinolab.search.potential.repulsion import Repulsion
from kinolab.simulation import Propagator
from kinolab.simulation.resimulated_goal import TrueEnds
from kinolab.steering import Arrival

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class FieldSettings:
    """What the search needs to know; the planner says what each one means."""

    navigation: bool
    escapes: int
    pull: float
    damping: float
    repulsion: float
    influence: float
    horizon: float
    draws: int
    resolution: float
    memory: float
    berth: float
    near: float
    patience: float


def solve(problem: Problem, settings: FieldSettings, seed: int, budget: Budget) -> SearchResult:
    """Search for a motion into the goal down a potential field."""
    propagator = Propagator(problem)
    if settings.navigation:
        unless_stopped(_load_solver, lambda: budget.interrupted)
    budget.restart()
    field = _field(propagator, settings, budget)
    if field is None:
        return _result(problem, Trail([problem.start]), Ending.BUDGET, budget, propagator, {})
    projection = Projection(problem.model, settings.pull, settings.damping)
    descent = _descent(field, projection, settings, propagator, budget)

    truth = TrueEnds(problem)

    def reaches(trail: Trail) -> bool:
        return truth.excess(_rows(problem, trail)[1]) <= 1.0

    escapes = Escapes(field, descent, projection, propagator, settings.escapes, reaches)
    ending, trail = escapes.search(problem, np.random.default_rng(seed), budget)
    statistics = {"potential_at_start": float(field.potential(problem.start[None])[0])}
    statistics |= {"minima": float(len(escapes.minima)), "escapes": float(escapes.made)}
    statistics |= truth.statistics
    if escapes.minima:
        statistics |= _where(problem, escapes)
    return _result(problem, trail, ending, budget, propagator, statistics)


def _load_solver() -> None:
    """Import the eikonal solver and solve for next to nothing: compiling is no part of a search."""
    for dims in (2, 3):
        shortest(np.ones((2,) * dims), np.ones(dims), sweeps=1)


def _field(propagator: Propagator, settings: FieldSettings, budget: Budget) -> Field | None:
    repulsion = Repulsion(settings.repulsion, settings.influence)
    if not settings.navigation:
        return plain_field(propagator.problem, repulsion)
    return navigation_field(
        propagator,
        repulsion,
        resolution=settings.resolution,
        memory=settings.memory,
        berth=settings.berth,
        stop=lambda: budget.over,
    )


def _descent(
    field: Field,
    projection: Projection,
    settings: FieldSettings,
    propagator: Propagator,
    budget: Budget,
) -> Descent:
    problem = field.problem
    steps = _steps(settings.horizon, problem)
    lookahead = Lookahead(field, projection, steps, settings.draws, lambda: budget.late)
    arrival = Arrival(problem, steps, propagator, lambda: budget.over)
    patience = _steps(settings.patience, problem)
    return Descent(field, lookahead, arrival, propagator, settings.near, patience)


def _steps(duration: float, problem: Problem) -> int:
    return max(1, round(min(duration / problem.step, 10_000.0)))


def _rows(problem: Problem, trail: Trail) -> tuple[Array, Array]:
    u = np.array(trail.inputs, dtype=float).reshape(-1, problem.model.nu)
    t: Array = problem.step * np.arange(len(u) + 1.0)
    return t, u


def _where(problem: Problem, escapes: Escapes) -> dict[str, float]:
    """Return where the lowest minimum is, by the names of the configuration."""
    lowest = min(escapes.minima, key=lambda minimum: minimum.height)
    names = problem.model.state_names[: problem.model.nq]
    place = {f"minimum_{n}": float(v) for n, v in zip(names, lowest.trail.end, strict=False)}
    return {"minimum_potential": lowest.height, **place}


def _result(
    problem: Problem,
    trail: Trail,
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
    if budget.interrupted:
        return Outcome.INTERRUPTED
    return Outcome.APPROXIMATE if steps else Outcome.NOT_FOUND
