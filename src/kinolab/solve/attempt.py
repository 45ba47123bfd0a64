"""One seed: search, re-simulate what was found, verify it, and say how it ended."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from threading import RLock
from typing import Any, TypeVar

import numpy as np

from kinolab import planners
from kinolab.errors import KinolabError
from kinolab.numerics.compiling import compilation
from kinolab.problem import Problem
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult
from kinolab.search.plugins import full_reference, search
from kinolab.simulation import stiffness
from kinolab.simulation.reference import DivergedError, follow_map, resimulate, trajectory_under
from kinolab.solve.garbage_collection import old_objects_left_alone
from kinolab.solve.plan import Plan
from kinolab.trajectory import Trajectory
from kinolab.verification import Certificate, verify

T = TypeVar("T")

MISSED = (Outcome.APPROXIMATE, Outcome.LOCAL_MINIMUM)  # the true motion may reach the goal
UNVERIFIED = "Interrupted before what was found had been verified."

# In threads one motion at a time: judged at once, each would take as long as all.
judging = RLock()


def make_planner(problem: Problem, name: str | None, settings: dict[str, Any]) -> AbstractPlanner:
    """Return a planner with the scenario's settings, overridden by those given here.

    The scenario's settings are those of the planner that it names: another one has its own.

    Raises:
        InputError: If the planner or a setting does not exist.
    """
    section = problem.scenario.planner
    own = full_reference(section.name, problem.scenario.folder)
    chosen = own if name is None else full_reference(name, Path.cwd())
    inherited = section.settings if chosen == own else {}
    return planners.make(chosen, {**inherited, **settings})


def attempt(
    problem: Problem,
    searcher: AbstractPlanner,
    seed: int,
    budget: Budget,
    *,
    keep_approach: bool = True,
) -> Plan:
    """Search with one seed and judge what it gave.

    Args:
        problem: What to solve.
        searcher: The planner with its settings.
        seed: Of the random numbers.
        budget: When to stop.
        keep_approach: Whether a motion that misses the goal is worth re-simulating.
    """
    return _Attempt(problem, searcher, seed, budget).plan(keep_approach)


def motion(
    problem: Problem, searcher: AbstractPlanner, seed: int, budget: Budget
) -> Trajectory | None:
    """Return the true motion of what a search found, which nobody has verified; None if nothing.

    Args:
        problem: What to solve.
        searcher: The planner with its settings.
        seed: Of the random numbers.
        budget: When to stop.
    """
    further = _Attempt(problem, searcher, seed, budget)
    try:
        result = further.search()
        return further.motion(result) if result.outcome is Outcome.SOLVED else None
    except KinolabError:
        return None


@dataclass
class _Attempt:
    """The stages of an attempt; each may be broken off, and what came before it is kept."""

    problem: Problem
    searcher: AbstractPlanner
    seed: int
    budget: Budget
    timings: dict[str, float] = field(default_factory=dict)

    def plan(self, keep_approach: bool) -> Plan:
        """Go through all stages."""
        result = self.search()
        with judging:
            if self.budget.abandoned:
                return self._plan("interrupted", result, math.nan, message=UNVERIFIED)
            return self._motion_judged(result, keep_approach)

    def _motion_judged(self, result: SearchResult, keep_approach: bool) -> Plan:
        if result.outcome in MISSED and not keep_approach:
            return self._plan(result.outcome.name.lower(), result, math.nan)
        try:
            trajectory = self.motion(result)
        except DivergedError as error:
            return self._plan("verification_failed", result, math.nan, message=str(error))
        if trajectory is None:
            return self._plan("interrupted", result, math.nan, message=UNVERIFIED)
        return self._judged(result, trajectory)

    def search(self) -> SearchResult:
        """Search, or return that nothing was found in time."""
        with old_objects_left_alone(), compilation() as compiling:
            self.budget.compiled = lambda: compiling.seconds
            found = self._timed(
                "search",
                lambda: search(self.searcher, self.problem, self.seed, self.budget),
                patience=1,
            )
        prepared = self.budget.prepared
        self.timings |= {"prepare": prepared, "search": self.timings["search"] - prepared}
        if found is None:  # it did not look at the budget
            nothing = np.zeros((0, self.problem.model.nu))
            return SearchResult(Outcome.INTERRUPTED, np.zeros(1), nothing, self.budget.iterations)
        return found

    def motion(self, result: SearchResult) -> Trajectory | None:
        """Return the true motion, or the planner's own where the user does not wait for it."""
        true = self._timed("simulate", lambda: resimulate(self.problem, result.t, result.u))
        if true is not None:
            return true
        model, settings = self.problem.model, self.problem.scenario.integration
        try:
            motion = follow_map(
                model, self.problem.start, result.t, result.u, settings.method, settings.substeps
            )
        except KinolabError:
            return None
        return trajectory_under(model, motion.t, motion.x, result.u)

    def _judged(self, result: SearchResult, trajectory: Trajectory) -> Plan:
        outcome, message = _outcome(self.problem, result.outcome, trajectory), ""
        found = outcome is not Outcome.NOT_FOUND and len(trajectory.u) > 0
        certificate = None
        if outcome is Outcome.SOLVED or (found and outcome is not Outcome.INTERRUPTED):
            certificate = self._certificate(trajectory)
            if certificate is None:
                outcome, message = Outcome.INTERRUPTED, UNVERIFIED
            elif outcome in MISSED and certificate.passed:
                outcome = Outcome.SOLVED  # the true motion reaches what the planner's own missed
            elif unsteady := self._unsteady(certificate, trajectory):
                status = "verification_failed" if outcome is Outcome.SOLVED else "not_found"
                return self._plan(status, result, math.nan, message=unsteady)
        return self._plan(
            _status(outcome, certificate),
            result,
            self.problem.goal_distance(trajectory.x[-1]),
            trajectory=trajectory if found or outcome is Outcome.SOLVED else None,
            certificate=certificate,
            message=message or outcome.value,
        )

    def _unsteady(self, certificate: Certificate, trajectory: Trajectory) -> str:
        """Say why what was found is no motion at all, where steps made it up; empty else.

        What a method makes of a stiff machine passes limits and walls that the machine keeps from,
        or keeps from what the machine runs into: to name one of them would blame the wrong thing.
        """
        wrong = any(check.name != "goal" for check in certificate.failures)
        found = stiffness(self.problem, trajectory.x) if wrong else None
        return f"What was found is no motion of this machine. {found.sentence}" if found else ""

    def _certificate(self, trajectory: Trajectory) -> Certificate | None:
        """Verify; None where the user does not wait for it."""
        if self.budget.interrupted:
            return None
        return self._timed("verify", lambda: verify(self.problem, trajectory))

    def _timed(self, stage: str, work: Callable[[], T], patience: int = 0) -> T | None:
        begun = time.perf_counter()
        done = self.budget.breaking(work, patience=patience)
        self.timings[stage] = time.perf_counter() - begun
        return done

    def _plan(
        self,
        status: str,
        result: SearchResult,
        goal_distance: float,
        *,
        trajectory: Trajectory | None = None,
        certificate: Certificate | None = None,
        message: str = "",
    ) -> Plan:
        return Plan(
            status,
            trajectory,
            certificate,
            self.searcher.name,
            self.seed,
            result.iterations,
            goal_distance,
            self.timings,
            dict(result.statistics),
            {cause: dict(shares) for cause, shares in result.rejections.items()},
            message or result.outcome.value,
            interrupted=self.budget.interrupted,
            graph=result.graph,
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
