"""kinolab's answer to a problem: a plan, made exact and shorter until the time is over."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import kinolab
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory

from .records import Improvement


@dataclass(frozen=True)
class Found:
    """What a search found.

    Attributes:
        trajectory: The best motion; None where there is none.
        improvements: All that were verified, in the order of time.
        setup: Seconds in which the planner got what it needs.
        complaint: What went wrong, where something did.
    """

    trajectory: Trajectory | None
    improvements: tuple[Improvement, ...]
    setup: float
    complaint: str


def load(file: Path, limit: float) -> PlanningTask:
    """Return a problem whose plans are improved for as long as a search may take, in [s]."""
    return kinolab.load(file, overrides=[f"planner.improve={limit}"])


def search(problem: PlanningTask, planner: str | None, seed: int, limit: float) -> Found:
    """Search and improve within a limit for both together, set-up apart.

    Args:
        problem: As the benchmark states it.
        planner: Its name; the usual one where None.
        seed: Of the random numbers.
        limit: In [s].
    """
    plan = problem.solve(planner, seed=seed, time_limit=limit)
    solved = plan.status == "solved"
    return Found(
        plan.trajectory if solved else None,
        tuple(
            Improvement(one.after, one.duration, one.by, one.goal_distance)
            for one in plan.improvements
        ),
        plan.timings.get("prepare", 0.0),
        "" if solved else plan.message,
    )
