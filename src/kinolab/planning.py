"""Problem -> planner -> re-simulation -> verification -> Plan."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from kinolab import planners
from kinolab.motion import DivergedError, resimulate
from kinolab.plugins import full_reference, search
from kinolab.problem import Problem
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult
from kinolab.trajectory import Trajectory
from kinolab.verification import Certificate, verify

EXIT_CODES = {
    "solved": 0,
    "simulated": 0,
    "not_found": 3,
    "approximate": 4,
    "local_minimum": 4,  # 3 where it is no nearer than the start
    "verification_failed": 7,
    "interrupted": 130,
}


@dataclass(frozen=True)
class Plan:
    """What planning gave.

    Attributes:
        status: ``solved`` (found and verified), ``approximate``, ``local_minimum``,
            ``not_found``, ``verification_failed`` or ``interrupted``.
        trajectory: The re-simulated motion, None where nothing was found.
        certificate: The outcome of all checks, None where nothing was found.
        planner: Name of the planner.
        seed: Seed of its random numbers.
        iterations: Number of extensions it tried.
        goal_distance: Norm of the goal errors at the end, in SI units.
        timings: Seconds per stage.
        statistics: What the planner counted.
        rejections: Share of all refused motions, by cause and by who is to blame.
        message: A sentence for the user.
    """

    status: str
    trajectory: Trajectory | None
    certificate: Certificate | None
    planner: str
    seed: int
    iterations: int
    goal_distance: float
    timings: dict[str, float] = field(default_factory=dict)
    statistics: dict[str, float] = field(default_factory=dict)
    rejections: dict[str, dict[str, float]] = field(default_factory=dict)
    message: str = ""

    @property
    def exit_code(self) -> int:
        """What the command line returns."""
        if self.status == "local_minimum" and self.trajectory is None:
            return EXIT_CODES["not_found"]
        return EXIT_CODES[self.status]

    @property
    def cost(self) -> float | None:
        """Duration in [s], None where nothing was found."""
        return None if self.trajectory is None else self.trajectory.duration


def make_planner(problem: Problem, name: str | None, settings: dict[str, Any]) -> AbstractPlanner:
    """Return a planner with the scenario's settings, overridden by those given here.

    A planner other than the scenario's takes over what both have.

    Raises:
        InputError: If the planner or a setting does not exist.
    """
    section = problem.scenario.planner
    own = full_reference(section.name, problem.scenario.folder)
    chosen = own if name is None else full_reference(name, Path.cwd())
    inherited = dict(section.settings)
    if chosen != own:
        inherited = planners.known_to(planners.get(chosen), inherited)
    return planners.make(chosen, inherited | settings)


def solve(
    problem: Problem,
    planner: str | None = None,
    seed: int | None = None,
    time_limit: float | None = None,
    *,
    max_iterations: int | None = None,
    progress: Callable[[int, float], None] | None = None,
    watch: Callable[[Budget], None] | None = None,
    **settings: Any,
) -> Plan:
    """Search for a plan, re-simulate it and verify it.

    Args:
        problem: What to solve.
        planner: Name of the planner, or ``file.py:Class`` with a path from the working folder; the
            scenario's when left out, as are the next three.
        seed: Seed of the random numbers.
        time_limit: Of the search, in [s].
        max_iterations: Of the search.
        progress: Called during the search with the iterations and seconds so far.
        watch: Called with the budget before the search, so that it can be interrupted.
        settings: Settings of the planner.

    Raises:
        EndpointError: If the start or the goal is impossible.
        InputError: If the planner or a setting does not exist.
    """
    section = problem.scenario.planner
    searcher = make_planner(problem, planner, settings)
    problem.check_endpoints()
    seed = section.seed if seed is None else seed
    limit = section.time_limit if time_limit is None else time_limit
    budget = Budget(limit, max_iterations or section.max_iterations, progress)
    if watch:
        watch(budget)
    begun = time.perf_counter()
    result = search(searcher, problem, seed, budget)
    timings = {"search": time.perf_counter() - begun}
    return _judge(problem, searcher, seed, result, timings)


def _judge(
    problem: Problem,
    searcher: AbstractPlanner,
    seed: int,
    result: SearchResult,
    timings: dict[str, float],
) -> Plan:
    """Re-simulate what was found, verify it, and say how it ended."""
    common: dict[str, Any] = {
        "planner": searcher.name,
        "seed": seed,
        "iterations": result.iterations,
        "timings": timings,
        "statistics": dict(result.statistics),
        "rejections": {cause: dict(shares) for cause, shares in result.rejections.items()},
    }
    begun = time.perf_counter()
    try:
        trajectory = resimulate(problem, result.t, result.u)
    except DivergedError as error:
        common |= {"goal_distance": math.nan, "message": str(error)}
        return Plan("verification_failed", None, None, **common)
    timings["simulate"] = time.perf_counter() - begun
    outcome = _outcome(problem, result.outcome, trajectory)
    found = outcome is not Outcome.NOT_FOUND and len(trajectory.u) > 0
    missed = outcome in (Outcome.APPROXIMATE, Outcome.LOCAL_MINIMUM)
    certificate = None
    if outcome is Outcome.SOLVED or (found and outcome is not Outcome.INTERRUPTED):
        begun = time.perf_counter()
        certificate = verify(problem, trajectory)
        timings["verify"] = time.perf_counter() - begun
        if missed and certificate.passed:
            outcome = Outcome.SOLVED  # the true motion reaches what the planner's own one missed
    return Plan(
        _status(outcome, certificate),
        trajectory if found or outcome is Outcome.SOLVED else None,
        certificate,
        goal_distance=problem.goal_distance(trajectory.x[-1]),
        message=outcome.value,
        **common,
    )


def _outcome(problem: Problem, claimed: Outcome, trajectory: Trajectory) -> Outcome:
    """Return how the search ended; an approach that comes no nearer than the start is none."""
    if claimed is Outcome.APPROXIMATE:
        begin, end = (problem.goal_distance(x) for x in (trajectory.x[0], trajectory.x[-1]))
        return claimed if end < begin else Outcome.NOT_FOUND
    return claimed


def _status(outcome: Outcome, certificate: Certificate | None) -> str:
    if outcome is Outcome.SOLVED:
        passed = certificate is not None and certificate.passed
        return "solved" if passed else "verification_failed"
    return outcome.name.lower()
