"""What planning gave, and how every seed that was tried ended."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from kinolab import planners
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner
from kinolab.search.graph import SearchGraph
from kinolab.search.plugins import full_reference
from kinolab.trajectory import Trajectory
from kinolab.verification import Certificate

REFUSED = "verification_failed"  # the status of what the verifier refused
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
class Attempt:
    """How the search with one seed ended.

    Attributes:
        seed: Seed of its random numbers.
        status: As of a plan, or ``ended`` where another seed had won or the user interrupted,
            or ``failed`` where its process or thread did not come to an end by itself.
        iterations: Number of extensions it tried.
        cost: Duration of the motion in [s], None where there is none.
        goal_distance: Norm of the goal errors at the end in SI units, None where that is unknown.
        after: Seconds from the beginning of the first search in its process or thread to its end.
        detail: A sentence where there is more to say.
        refused: How many motions it found that the verifier refused.
    """

    seed: int
    status: str
    iterations: int
    cost: float | None = None
    goal_distance: float | None = None
    after: float = 0.0
    detail: str = ""
    refused: int = 0


@dataclass(frozen=True, order=True)
class Improvement:
    """A verified motion on the way to a plan.

    Attributes:
        after: Seconds from the beginning of the first search in its process or thread, without
            what was compiled and loaded.
        duration: Of the motion in [s]; one that ends exactly in the goal's centre may take longer
            than the one that it was made of.
        goal_distance: Norm of the goal errors at the end, in SI units.
        by: What made it: ``search``, ``repair`` or ``shorten``.
        seed: Of the search that it began with.
    """

    after: float
    duration: float
    goal_distance: float
    by: str
    seed: int


@dataclass(frozen=True)
class PlanResult:
    """What planning gave.

    Attributes:
        status: ``solved`` (found and verified), ``approximate``, ``local_minimum``,
            ``not_found``, ``verification_failed`` or ``interrupted``.
        trajectory: The re-simulated motion, None where nothing was found.
        certificate: The outcome of all checks, None where nothing was found.
        planner: Name of the planner.
        seed: Seed of its random numbers.
        iterations: Number of extensions it tried until its first motion that was not refused.
        goal_distance: Norm of the goal errors at the end, in SI units.
        timings: Seconds per stage.
        statistics: What the planner counted.
        rejections: Fraction of all refused motions, by cause and by who is to blame.
        message: A sentence for the user.
        jobs: Number of searches at once.
        attempts: How every seed ended that was tried, this one's included.
        interrupted: Whether the user ended the search; a plan that was verified before is kept.
        improvements: All motions that were verified, in the order of time.
        graph: What the search explored that the motion began with; None where that is not kept.
        refused: How many motions the search found that the verifier refused, by the checks that
            they did not pass; the search went on.
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
    jobs: int = 1
    attempts: tuple[Attempt, ...] = ()
    interrupted: bool = False
    improvements: tuple[Improvement, ...] = ()
    graph: SearchGraph | None = None
    refused: dict[str, int] = field(default_factory=dict)

    @property
    def exit_code(self) -> int:
        """What the command line returns."""
        if self.status == "local_minimum" and self.trajectory is None:
            return EXIT_CODES["interrupted" if self.interrupted else "not_found"]
        return EXIT_CODES["interrupted" if self.interrupted else self.status]

    @property
    def cost(self) -> float | None:
        """Duration in [s], None where nothing was found."""
        return None if self.trajectory is None else self.trajectory.duration


@dataclass(frozen=True)
class Request:
    """Which searches to make, one after the other.

    Attributes:
        planner: Name of the planner; None for the scenario's.
        settings: Of the planner, over the scenario's.
        seed: Of the first search.
        stride: From one seed to the next.
        time_limit: Of all searches of one process or thread together, in [s].
        max_iterations: Of each search, None for no limit.
        anytime: Whether to go on with further seeds until the time is over.
        optimize: Whether to make exact and shorten what is found.
    """

    planner: str | None
    settings: dict[str, Any] = field(default_factory=dict)
    seed: int = 1
    stride: int = 1
    time_limit: float = 30.0
    max_iterations: int | None = None
    anytime: bool = False
    optimize: bool = True

    def seeds(self) -> Iterator[int]:
        """Yield the seeds to try."""
        return count(self.seed, self.stride) if self.anytime else iter((self.seed,))

    def split(self, jobs: int) -> Iterator[Request]:
        """Yield what each of several at once does, so that none tries a seed of another's."""
        for k in range(jobs):
            yield replace(self, seed=self.seed + k, stride=jobs)


def make_planner(
    problem: PlanningTask, name: str | None, settings: dict[str, Any]
) -> AbstractPlanner:
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


def stream(seed: int, k: int) -> int:
    """Return the seed of the k-th further search after one with a seed."""
    return int(np.random.SeedSequence((seed, k)).generate_state(1)[0])
