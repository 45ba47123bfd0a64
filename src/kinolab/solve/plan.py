"""Plan results, attempts with each seed, and search requests."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kinolab import planners
from kinolab.errors import InputError, Mistake, unknown_name
from kinolab.problem import PlanningTask
from kinolab.scenario import Effort
from kinolab.search import AbstractPlanner, Budget
from kinolab.search.graph import SearchGraph
from kinolab.search.plugins import full_reference
from kinolab.settings import settings_of
from kinolab.trajectory import Trajectory
from kinolab.verification import Certificate

if TYPE_CHECKING:
    from kinolab.verification.tube.claim import Claim

CENTRE_TOLERANCE = 1e-4  # SI units, goal distance of a motion that ends in the goal's centre
REFUSED = "verification_failed"  # the status of a plan that the verifier rejected
CLASSES = ("solved", "nearest", REFUSED, "not_found")  # best first
NEAREST = {"approximate", "local_minimum", "interrupted"}  # statuses of motions that end elsewhere
EXIT_CODES = {
    "solved": 0,
    "simulated": 0,
    "not_found": 3,
    "approximate": 4,
    "local_minimum": 4,  # 3 if it is no nearer than the start
    "verification_failed": 7,
    "interrupted": 130,
}


@dataclass(frozen=True)
class Attempt:
    """How the search with one seed ended.

    Attributes:
        seed: Random seed.
        status: As of a plan, or ``ended`` if another seed had won or the user interrupted, or
            ``failed`` if its process or thread did not complete.
        iterations: Number of attempted extensions.
        cost: Duration of the motion in [s], None if there is none.
        goal_distance: Norm of the goal errors at the end in SI units, None if unknown.
        after: Seconds from the beginning of the first search in its process or thread to its end.
        detail: Further explanation, if any.
        refused: Number of motions that the verifier rejected.
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
    """A verified intermediate solution.

    Attributes:
        after: Seconds from the beginning of the first search in its process or thread, without
            compilation and loading.
        duration: Of the motion in [s]; one that ends exactly in the goal's centre may take longer
            than the one it was derived from.
        goal_distance: Norm of the goal errors at the end, in SI units.
        by: The stage that produced it: ``search``, ``repair``, ``shorten`` or ``cheapen``.
        seed: Random seed of the search that it started from.
        price: As of a plan.
    """

    after: float
    duration: float
    goal_distance: float
    by: str
    seed: int
    price: float | None = None


@dataclass(frozen=True)
class PlanResult:
    """Result of planning.

    Attributes:
        status: ``solved`` (found and verified), ``approximate``, ``local_minimum``,
            ``not_found``, ``verification_failed`` or ``interrupted``.
        trajectory: The re-simulated motion, None if nothing was found.
        certificate: The outcome of all checks, None if nothing was found.
        planner: Name of the planner.
        seed: Random seed.
        iterations: Number of attempted extensions until the first motion that was not rejected.
        goal_distance: Norm of the goal errors at the end, in SI units.
        timings: Seconds per stage.
        statistics: The planner's counters.
        rejections: Fractions of all motions that the search rejected, by cause and source.
        message: Explanation for the user.
        jobs: Number of parallel searches.
        attempts: Outcome of every seed tried, including this one.
        interrupted: Whether the user ended the search; a plan verified before that is kept.
        improvements: All verified motions, in order of time.
        graph: Search graph of the motion's first search; None if not kept.
        refused: Number of motions that the verifier rejected, by failed checks; the search
            continued.
        warnings: What the plan does not suffer from but the search did, in sentences.
        search_work: What the search takes on an idle computer, about, in [s].
        price: What the motion costs by the scenario's [objective], None without one.
        claim: What is proved of it under the scenario's [robust], None without one.
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
    warnings: tuple[str, ...] = ()
    search_work: float = 0.0
    price: float | None = None
    claim: Claim | None = None

    @property
    def exit_code(self) -> int:
        """Exit code of the command line."""
        if self.status == "solved" and self.claim is not None and not self.claim.proved:
            return EXIT_CODES[REFUSED]
        if self.status == "local_minimum" and self.trajectory is None:
            return EXIT_CODES["interrupted" if self.interrupted else "not_found"]
        return EXIT_CODES["interrupted" if self.interrupted else self.status]

    @property
    def duration(self) -> float | None:
        """Of the motion in [s], None if nothing was found."""
        return None if self.trajectory is None else self.trajectory.duration

    @property
    def cost(self) -> float | None:
        """What the motion costs by [objective], or else its duration in [s]; None without one."""
        return self.duration if self.price is None else self.price

    @property
    def rank(self) -> tuple[int, float, float]:
        """Sort key, smaller is better.

        Verified plans that end in the goal's centre come before those that end elsewhere within
        its tolerance, then those of less cost first; plans that miss the goal or are unverified are
        ordered by their distance from it.
        """
        if self.status == "solved":
            return 0, float(self.goal_distance > CENTRE_TOLERANCE), self.cost or 0.0
        near = self.status in NEAREST and self.trajectory is not None
        kind = "nearest" if near else self.status
        place = CLASSES.index(kind) if kind in CLASSES else len(CLASSES)
        return place, self.goal_distance if math.isfinite(self.goal_distance) else math.inf, 0.0


@dataclass(frozen=True)
class Request:
    """A sequence of searches to make.

    Attributes:
        planner: Name of the planner; None for the scenario's.
        settings: Of the planner, overriding the scenario's.
        seed: Of the first search.
        stride: Increment from one seed to the next.
        time_limit: Of all searches of one process or thread together, in [s].
        max_iterations: Of each search, None for no limit.
        anytime: Whether to continue with further seeds until the time limit.
        optimize: Whether to make solutions exact and shorter.
        improve: Seconds of work for that, or ``"auto"``; None for the scenario's.
        guess: A motion that is tried before the first search, if any.
        jobs: Number of parallel searches.
        contained: Whether each of several has a process of its own in any case.
        robust: Whether a plan is proved under the scenario's [robust], if it has one.
    """

    planner: str | None
    settings: dict[str, Any] = field(default_factory=dict)
    seed: int = 1
    stride: int = 1
    time_limit: float = 30.0
    max_iterations: int | None = None
    anytime: bool = False
    optimize: bool = True
    improve: Effort | None = None
    guess: Trajectory | None = None
    jobs: int = 1
    contained: bool = False
    robust: bool = True

    def effort(self, problem: PlanningTask) -> Effort:
        """Return the work on making solutions better, in [s] or ``"auto"``."""
        return problem.scenario.planner.improve if self.improve is None else self.improve

    def seeds(self) -> Iterator[int]:
        """Yield the seeds to try."""
        return count(self.seed, self.stride) if self.anytime else iter((self.seed,))

    def split(self) -> Iterator[Request]:
        """Yield the request of each parallel job, with disjoint seeds."""
        for k in range(self.jobs):
            yield replace(self, seed=self.seed + k, stride=self.jobs)


@dataclass(frozen=True)
class Listeners:
    """What is called while it is planned.

    Attributes:
        progress: During a search, with the iterations and seconds so far, of all searches.
        watch: With the budget before each search, so that it can be interrupted.
        improved: With each verified plan that is better than those before.
    """

    progress: Callable[[int, float], None] | None = None
    watch: Callable[[Budget], None] | None = None
    improved: Callable[[PlanResult], None] | None = None


def make_planner(
    problem: PlanningTask, name: str | None, settings: dict[str, Any]
) -> AbstractPlanner:
    """Return a planner with the scenario's settings, overridden by the given ones.

    The scenario's settings apply only to the planner that it names.

    Raises:
        InputError: If the planner or a setting does not exist, or it cannot plan for the machine.
    """
    section = problem.scenario.planner
    own = full_reference(section.name, problem.scenario.folder)
    chosen = own if name is None else full_reference(name, Path.cwd())
    inherited = section.settings if chosen == own else {}
    _require_known(chosen, settings)
    made = planners.make(chosen, {**inherited, **settings})
    what = ""
    if problem.machine.modes and not made.hybrid:
        what = f"{made.name} does not plan for machines with modes."
    elif problem.model.clocks and not made.waits:
        what = f"{made.name} plans in a world that stands still, and something in it moves."
    if what:
        raise InputError([Mistake("[planner] name", what, "Take auto, rrt_fast or kpiece_fast.")])
    return made


def _require_known(chosen: str, settings: Mapping[str, Any]) -> None:
    """Require that a planner has the settings of a call; its other arguments may be meant.

    Raises:
        InputError: With every unknown one.
    """
    planner = planners.get(chosen)
    known = sorted(entry.name for entry in settings_of(planner))
    arguments = {entry.name for entry in fields(Request)} - {"settings", "stride"}
    kind, unknown = f"setting of {planner.name}", [key for key in settings if key not in known]
    if unknown:
        raise InputError(
            unknown_name(kind, key, known=known, also=arguments, where=f"[planner] {key}")
            for key in unknown
        )


def stream(seed: int, k: int) -> int:
    """Derive the seed of the k-th further search from the first one's."""
    return int(np.random.SeedSequence((seed, k)).generate_state(1)[0])
