"""One attempt with one seed: search, re-simulate and verify."""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from threading import RLock
from typing import TypeVar

import numpy as np

from kinolab.errors import KinolabError
from kinolab.numerics.compiling import compilation
from kinolab.numerics.work import charge, counted_work
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult
from kinolab.search.plugins import search
from kinolab.simulation import stiffness
from kinolab.simulation.reference import (
    DivergedError,
    follow_map,
    price,
    resimulate,
    trajectory_under,
)
from kinolab.simulation.step_error import step_error
from kinolab.solve.plan import REFUSED, PlanResult
from kinolab.trajectory import Trajectory
from kinolab.verification import Certificate, verify

T = TypeVar("T")

MISSED = (Outcome.APPROXIMATE, Outcome.LOCAL_MINIMUM)  # re-simulation may still reach the goal

# Threads verify one motion at a time: concurrently, each would take as long as all.
judging = RLock()


@dataclass(frozen=True)
class Verdict:
    """Verification outcome of a search result; the attributes are those of a plan."""

    status: str
    message: str
    trajectory: Trajectory | None = None
    certificate: Certificate | None = None
    goal_distance: float = math.nan


MIN_SEARCH_WORK = 0.03  # [s] on an idle computer, what begins and ends a search included

UNVERIFIED = Verdict("interrupted", "Interrupted before what was found had been verified.")


def attempt(
    problem: PlanningTask,
    searcher: AbstractPlanner,
    seed: int,
    budget: Budget,
    *,
    keep_approach: bool = True,
) -> PlanResult:
    """Search with one seed and verify the result; on interrupt, keep what is complete.

    Args:
        searcher: The planner with its settings.
        budget: When to stop.
        keep_approach: Whether to re-simulate a motion that misses the goal.
    """
    timings: dict[str, float] = {}
    with counted_work() as work:
        result = _searched(problem, searcher, seed, budget, timings)
    with judging:
        if budget.abandoned:
            verdict = UNVERIFIED
        elif result.outcome in MISSED and not keep_approach:
            verdict = Verdict(result.outcome.name.lower(), result.outcome.value)
        else:
            verdict = _judged(problem, result, budget, timings)
    # What is wrong with the planner's own steps along what it found.
    wrong = None if verdict.trajectory is None else step_error(problem, verdict.trajectory)
    return PlanResult(
        verdict.status,
        verdict.trajectory,
        verdict.certificate,
        searcher.name,
        seed,
        result.iterations,
        verdict.goal_distance,
        timings,
        dict(result.statistics),
        {cause: dict(shares) for cause, shares in result.rejections.items()},
        verdict.message,
        interrupted=budget.interrupted,
        graph=result.graph,
        warnings=(*result.warnings, *(() if wrong is None else (wrong.sentence,))),
        search_work=work.seconds,
        price=price(problem, verdict.trajectory) if verdict.trajectory is not None else None,
    )


def motion(
    problem: PlanningTask, searcher: AbstractPlanner, seed: int, budget: Budget
) -> Trajectory | None:
    """Search and re-simulate without verification; None if no solution is found.

    Args:
        searcher: The planner with its settings.
        budget: When to stop.
    """
    try:
        result = _searched(problem, searcher, seed, budget, {})
        solved = result.outcome is Outcome.SOLVED
        return _simulated(problem, result, budget, {}) if solved else None
    except KinolabError:
        return None


def _timed(
    work: Callable[[], T],
    budget: Budget,
    timings: dict[str, float],
    stage: str,
    patience: int = 0,
) -> T | None:
    """Run a stage and record its seconds in ``timings``; None if it is aborted."""
    if budget.stage:
        budget.stage(stage)
    begun = time.perf_counter()
    done = budget.breaking(work, patience=patience)
    timings[stage] = time.perf_counter() - begun
    return done


def _searched(
    problem: PlanningTask,
    searcher: AbstractPlanner,
    seed: int,
    budget: Budget,
    timings: dict[str, float],
) -> SearchResult:
    """Search; an aborted search gives an empty, interrupted result."""
    with old_objects_left_alone(), compilation() as compiling:
        budget.compiled = lambda: compiling.seconds
        found = _timed(
            lambda: search(searcher, problem, seed, budget), budget, timings, "search", patience=1
        )
    charge(max(MIN_SEARCH_WORK, searcher.work_per_iteration * budget.iterations))
    timings |= {"prepare": budget.prepared, "search": timings["search"] - budget.prepared}
    if found is None:  # it did not check the budget
        nothing = np.zeros((0, problem.model.nu))
        return SearchResult(Outcome.INTERRUPTED, np.zeros(1), nothing, budget.iterations)
    return found


def _simulated(
    problem: PlanningTask, result: SearchResult, budget: Budget, timings: dict[str, float]
) -> Trajectory | None:
    """Re-simulate a search result; fall back to the planner's own motion if interrupted."""
    true = _timed(lambda: resimulate(problem, result.t, result.u), budget, timings, "simulate")
    if true is not None:
        return true
    model, settings = problem.model, problem.scenario.integration
    try:
        own = follow_map(
            model, problem.start, result.t, result.u, settings.method, settings.substeps
        )
    except KinolabError:
        return None
    return trajectory_under(model, own.t, own.x, result.u)


def _judged(
    problem: PlanningTask, result: SearchResult, budget: Budget, timings: dict[str, float]
) -> Verdict:
    """Re-simulate a search result, and verify it if it may be a solution."""
    try:
        trajectory = _simulated(problem, result, budget, timings)
    except DivergedError as error:
        return Verdict(REFUSED, str(error))
    if trajectory is None:
        return UNVERIFIED
    outcome, distance = result.outcome, problem.goal_distance(trajectory.x[-1])
    if outcome is Outcome.APPROXIMATE and not distance < problem.goal_distance(trajectory.x[0]):
        outcome = Outcome.NOT_FOUND
    found = outcome is not Outcome.NOT_FOUND and len(trajectory.u) > 0
    kept = trajectory if found or outcome is Outcome.SOLVED else None
    if kept is None or outcome is Outcome.INTERRUPTED:
        return Verdict(outcome.name.lower(), outcome.value, kept, goal_distance=distance)
    certificate = None
    if not budget.interrupted:
        certificate = _timed(
            lambda: verify(problem, trajectory, budget.told), budget, timings, "verify"
        )
    if certificate is None:
        return replace(UNVERIFIED, trajectory=trajectory if found else None, goal_distance=distance)
    if certificate.passed:  # re-simulation may reach a goal that the planner missed
        return Verdict("solved", Outcome.SOLVED.value, kept, certificate, distance)
    missed = outcome in MISSED
    if unsteady := _unsteady(problem, certificate, trajectory):
        return Verdict("not_found" if missed else REFUSED, unsteady)
    status = outcome.name.lower() if missed else REFUSED
    return Verdict(status, outcome.value, kept, certificate, distance)


def _unsteady(problem: PlanningTask, certificate: Certificate, trajectory: Trajectory) -> str:
    """Explain a motion that is an artefact of an unstable integrator; empty if it is none.

    With too long steps on a stiff machine, limit violations and collisions are as spurious as their
    absence: to name one of them would blame the wrong thing.
    """
    wrong = any(check.name != "goal" for check in certificate.failures)
    found = stiffness(problem, trajectory.x) if wrong else None
    return f"What was found is no motion of this machine. {found.sentence}" if found else ""


@contextmanager
def old_objects_left_alone() -> Iterator[None]:
    """Exclude existing objects from garbage collection inside this context.

    Imported modules and derived equations make about a million objects. A full collection takes a
    tenth of a second, in which no budget is checked, and frees nothing.
    """
    mine = not gc.get_freeze_count()  # otherwise a caller froze them and will unfreeze them
    if mine:
        gc.freeze()
    try:
        yield
    finally:
        if mine:
            gc.unfreeze()
