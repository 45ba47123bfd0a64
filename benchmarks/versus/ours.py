"""kinolab's side: searches in this process, one after the other."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import kinolab
from kinolab import planners
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Array, Budget, Outcome
from kinolab.settings import settings_of

from .runs import AS_IN_OMPL, Entrant, Run
from .verdict import Judge

FOLDER = Path(__file__).resolve().parent
UNREACHABLE = "goal.tolerance=1e-9"  # [m] and the like: it is aimed at, as ever


class SearchBudget(Budget):
    """A budget that knows when the search began.

    It is of CPU time, as OMPL's side has it, but by the clock for several threads.
    """

    cpu = wall = 0.0  # [s] of the processor and on the monotonic clock

    def restart(self) -> None:
        """Begin to count the time now."""
        super().restart()
        self.cpu, self.wall = time.process_time(), time.monotonic()


def load(problem: str, *overrides: str) -> PlanningTask:
    """Return one of the two problems."""
    return kinolab.load(FOLDER / f"{problem}.toml", overrides=overrides)


def make(entrant: Entrant) -> AbstractPlanner:
    """Return a planner of kinolab's with its settings."""
    kind = planners.get(entrant.planner)
    known = {entry.name for entry in settings_of(kind)} if entrant.like else set()
    settings = {name: value for name, value in AS_IN_OMPL.items() if name in known}
    return kind(**settings, **({"threads": entrant.threads} if entrant.threads > 1 else {}))


def search(problem: str, judge: Judge, entrant: Entrant, seed: int, limit: float) -> Run:
    """Search once, and judge what was found; the verdict at the knots is timed."""
    clock = time.process_time if entrant.threads == 1 else time.monotonic
    planner, budget = make(entrant), SearchBudget(limit, clock=clock)
    found = planner.solve(judge.problem, seed, budget)
    cpu, wall = time.process_time() - budget.cpu, time.monotonic() - budget.wall
    solved = found.outcome is Outcome.SOLVED
    judged = _judged(judge, found.u) if solved else {}
    return Run(
        problem,
        entrant,
        seed,
        solved=solved,
        cpu=cpu if solved else limit,
        wall=wall if solved else limit,
        setup=budget.prepared,
        nodes=int(found.statistics.get("nodes", 0)),
        propagations=int(found.statistics.get("propagations", 0)),
        **judged,
    )


def _judged(judge: Judge, u: Array) -> dict[str, Any]:
    cpu, wall = time.process_time(), time.monotonic()
    at_knots = judge.at_knots(u)
    cpu, wall = time.process_time() - cpu, time.monotonic() - wall
    return {
        "at_knots": at_knots,
        "between": "" if at_knots else judge.between(u),
        "judging_cpu": cpu,
        "judging_wall": wall,
        "duration": judge.problem.step * len(u),
    }
