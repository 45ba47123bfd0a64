"""Plan improvement after a first solution: make it exact, shorten it, and search again.

The result is never worse than the first solution, and every incumbent has been verified.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from typing import TypeVar

import numpy as np

from kinolab import trajopt
from kinolab.concurrency.cancel import never_cancelled
from kinolab.errors import KinolabError
from kinolab.numerics.compiling import compilation
from kinolab.numerics.work import charge, counted_work
from kinolab.problem import PlanningTask
from kinolab.scenario import Effort, improvement_seconds
from kinolab.search import AbstractPlanner, Budget
from kinolab.solve.attempt import MIN_SEARCH_WORK, judging, motion
from kinolab.solve.plan import CENTRE_TOLERANCE, REFUSED, Improvement, PlanResult, Request, stream
from kinolab.trajectory import Trajectory
from kinolab.verification import verify

T = TypeVar("T")

SEARCHED_ALONE = "Found a trajectory into the goal region, which the search alone had missed."
# of the improvement's work, to make a motion exact before it is shortened
EXACTNESS_FRACTION = 0.25
# the same for what searches find, at once and apart from that work
EXACTNESS_AT_ONCE_FRACTION = 0.05
MIN_GAIN = 1e-3  # fraction of the duration that justifies another round
VERIFIED_GAIN = 0.03  # the same for a verification while more is to come
MAX_REFUSALS = 2  # shorter motions that the verifier refuses before others are tried
# of the time limit, for repairing a motion that the verifier rejects
REPAIR_TIME_FRACTION = 0.1
MIN_REPAIR_SECONDS = 2.0  # [s] for that at least
# Where nobody says how much work improvement may take, a motion of more steps than this gets more
# in proportion, so many times as much at most.
SHORT_MOTION, MAX_GROWTH = 200, 5.0
PATIENCE = 8.0  # times as many seconds by the clock may the improvement take, on a busy computer
VERIFICATION_SECONDS = 2e-4  # [s] for each knot, as ``charge`` counts it
# Further searches may each take this many times the first one's iterations, and some more.
SEARCH_FACTOR, MORE_ITERATIONS = 2, 200
# Before a motion is improved, so many searches are made, as far as this fraction of the work pays
# for them: fewer than some are not worth it. Each ends after twice what it should take, since
# guesses may take long.
FIRST_SEARCHES, LEAST_FIRST_SEARCHES, FIRST_FRACTION, FIRST_FACTOR = 4, 3, 0.15, 2.0
# Before one motion is shortened to the end, it and the shortest of the others are each shortened
# with this fraction of the work, and so many seconds at most, if that is enough to see something:
# so many seconds for each of the motion's steps.
RACE_FRACTION, MOST_RACE_SECONDS, RACE_SECONDS_PER_STEP = 0.2, 1.25, 4e-3
# Further searches are of three kinds in turn.
GUESSED, SEARCHED, BOUNDED = KINDS = range(3)
# added to the number of a search below a bound, or by guesses: other random numbers
BOUNDED_STREAM, GUESSED_STREAM = 10_000, 20_000


@dataclass
class Incumbent:
    """The best verified plan so far.

    Attributes:
        problem: The planning problem.
        best: The best plan so far: its search's result with the improved motion.
        budget: Carries interrupts by the user.
        time: Returns the seconds since the first search began.
        on_improved: Called with each verified plan that is better than those before.
        improvements: All verified motions.
        work: Returns the seconds of work that improvement has taken.
        gains: That and the duration in [s], of each of them.
    """

    problem: PlanningTask
    best: PlanResult
    budget: Budget
    time: Callable[[], float]
    on_improved: Callable[[PlanResult], None] | None = None
    improvements: list[Improvement] = field(default_factory=list)
    work: Callable[[], float] = lambda: 0.0
    gains: list[tuple[float, float]] = field(default_factory=list)

    @property
    def search_work(self) -> float:
        """What a search like that of the best plan takes on an idle computer, in [s]."""
        return max(self.best.search_work, MIN_SEARCH_WORK)

    def cancelled(self) -> bool:
        """Say whether the user has interrupted or the search was abandoned."""
        return self.budget.interrupted or self.budget.abandoned

    def begin(self) -> None:
        """Record the search's plan."""
        if self.best.status == "solved":
            self._keep(self.best, "search")

    def tried(self, work: Callable[[], T]) -> T | None:
        """Run some work; None if it fails or is interrupted."""
        if self.cancelled():
            return None
        try:
            return self.budget.breaking(work, patience=1)
        except (KinolabError, ArithmeticError):
            return None  # there is a plan already

    def beaten_by(self, trajectory: Trajectory, gain: float = 0.0) -> bool:
        """Say whether a motion would improve on the best, by a fraction of the time if alike."""
        new, old = self._with(trajectory).rank, self.best.rank
        return new < old and (new[:2] < old[:2] or new[2] < (1 - gain) * old[2])

    def take(self, trajectory: Trajectory, by: str) -> bool:
        """Verify a motion that would improve on the best; return whether it is kept."""
        found, certificate = self._with(trajectory), None
        if found.rank < self.best.rank:
            charge(VERIFICATION_SECONDS * len(trajectory.t))
            with judging:  # may block for a while
                if not self.cancelled():
                    certificate = self.budget.breaking(
                        lambda: verify(self.problem, trajectory, self.budget.told)
                    )
        kept = certificate is not None and certificate.passed
        if kept:
            self._keep(replace(found, certificate=certificate), by)
        return kept

    def plan(
        self,
        timings: Mapping[str, float] | None = None,
        statistics: Mapping[str, float] | None = None,
    ) -> PlanResult:
        """Return the best plan with timings, statistics and improvements."""
        return replace(
            self.best,
            timings={**self.best.timings, **(timings or {})},
            statistics={**self.best.statistics, **(statistics or {})},
            interrupted=self.best.interrupted or self.budget.interrupted,
            improvements=tuple(self.improvements),
        )

    def _with(self, trajectory: Trajectory) -> PlanResult:
        """Return the best plan with another motion, as if that were verified."""
        return replace(
            self.best,
            status="solved",
            trajectory=trajectory,
            goal_distance=self.problem.goal_distance(trajectory.x[-1]),
            message=self.best.message if self.best.status == "solved" else SEARCHED_ALONE,
        )

    def _keep(self, found: PlanResult, by: str) -> None:
        made = Improvement(self.time(), found.cost or 0.0, found.goal_distance, by, found.seed)
        self.improvements.append(made)
        self.gains.append((self.work(), made.duration))
        self.best = found
        if self.on_improved:
            self.on_improved(replace(found, improvements=tuple(self.improvements)))


@dataclass
class Shortening:
    """A motion that is made shorter and shorter, as long as one wants.

    Attributes:
        incumbent: The best plan; those that are better are verified on the way.
        given: The motion to begin with.
        remaining: Budget of work.
        best: The shortest motion derived from the given one so far, or that one itself.
    """

    incumbent: Incumbent
    given: Trajectory
    remaining: Budget
    best: Trajectory = field(init=False)
    _refusals: int = 0

    def __post_init__(self) -> None:
        self.best = self.given
        spent = self.remaining.fraction()
        self._motions = trajopt.shortened(self.incumbent.problem, self.given, spent)

    def until(self, enough: Callable[[], bool]) -> Trajectory:
        """Go on until that is enough, or nothing more is gained; return the shortest motion."""
        incumbent, best = self.incumbent, self.best
        while self._refusals < MAX_REFUSALS and not enough():
            motion = incumbent.tried(lambda: next(self._motions, None))
            if motion is None:
                break
            if not incumbent.beaten_by(motion, VERIFIED_GAIN) or incumbent.take(motion, "shorten"):
                self.best = motion
            else:
                self._refusals += 1
        if self.best is not best and incumbent.beaten_by(self.best):
            incumbent.take(self.best, "shorten")
        return self.best


@dataclass
class PlanImprover:
    """Improves the plans of one process or thread.

    Attributes:
        problem: The planning problem.
        searcher: The planner, to search again.
        request: Time limit, seeds and options.
        elapsed: Returns the seconds since the first search began.
        watch: Called with the budget of each further search, so that it can be interrupted.
        on_improved: Called with each verified plan that is better than those before with this seed.
    """

    problem: PlanningTask
    searcher: AbstractPlanner
    request: Request
    elapsed: Callable[[], float]
    watch: Callable[[Budget], None] | None = None
    on_improved: Callable[[PlanResult], None] | None = None
    _incumbent: Incumbent = field(init=False)  # of the plan that is being improved
    _shortest: float = math.inf  # [s] of all plans
    _unfinished: bool = False  # whether more work might give a shorter motion
    _out_of_time: float = 0.0  # [s] the time limit, where it ended an improvement
    _gained: float = 1.0  # largest factor by which a duration was reduced
    _growth: float = 1.0  # of the work, for a long motion

    def plan(self, found: PlanResult, budget: Budget) -> PlanResult:
        """Return an improved plan, or the same one.

        Args:
            found: A search's plan.
            budget: The budget of that search.
        """
        self._growth = self._growth_for(found.trajectory)
        with compilation() as compiled:
            incumbent = self._incumbent = Incumbent(
                self.problem,
                found,
                budget,
                lambda: self.elapsed() - compiled.seconds,  # compilation does not count
                self.on_improved,
            )
            incumbent.begin()
            wanted = self.request.optimize and self._seconds and not incumbent.cancelled()
            promises = found.status != "solved" or self._promises(found.cost)
            if found.trajectory is None or not (wanted and promises):
                self._learn()
                return incumbent.plan()
            begun, further = incumbent.time(), self._improve(found.trajectory)
            statistics = _statistics(found, incumbent.best, further)
            statistics["improvement_unfinished"] = float(self._unfinished)
            statistics["improvement_out_of_time"] = self._out_of_time
            statistics["improvement_seconds"] = self._seconds  # of work that it was allowed
            statistics["last_half_gain"] = _last_half_gain(incumbent.gains, self._seconds)
            return incumbent.plan({"improve": incumbent.time() - begun}, statistics)

    @property
    def _seconds(self) -> float:
        return self._growth * improvement_seconds(self._wanted)

    @property
    def _wanted(self) -> Effort:
        own = self.request.improve
        return self.problem.scenario.planner.improve if own is None else own

    def _growth_for(self, found: Trajectory | None) -> float:
        """Return how many times the usual work a motion gets, of which nobody says how much."""
        if found is None or self._wanted != "auto":
            return 1.0
        steps = found.duration / self.problem.step
        return min(max(steps / SHORT_MOTION, 1.0), MAX_GROWTH)

    def _promises(self, duration: float | None) -> bool:
        """Say whether a motion would beat all others if it gained as much as they did."""
        return duration is not None and duration < self._gained * self._shortest

    def _learn(self, gained: float = 1.0) -> None:
        """Update the shortest duration and the largest reduction factor."""
        best = self._incumbent.best
        if best.status == "solved" and best.cost is not None:
            self._shortest = min(self._shortest, best.cost)
            self._gained = max(self._gained, gained)

    def _improve(self, first: Trajectory) -> int:
        """Improve a motion, then those of further searches; return the number of searches.

        A rejected motion is repaired if possible; otherwise the caller searches again.
        """
        self._unfinished, self._out_of_time, incumbent = False, 0.0, self._incumbent
        refused, limit = incumbent.best.status == REFUSED, self.request.time_limit
        seconds, begun = self._seconds, incumbent.time()
        if refused:  # most of the time is for another search
            seconds = min(seconds, max(MIN_REPAIR_SECONDS, REPAIR_TIME_FRACTION * limit))
        patience = min(PATIENCE * seconds, limit - begun)

        def cancelled() -> bool:
            return incumbent.cancelled() or incumbent.time() - begun > patience

        with counted_work() as work:
            incumbent.work = lambda: work.seconds
            remaining = Budget(seconds, clock=lambda: work.seconds, cancelled=cancelled)
            if patience <= 0.0:  # a plan found late is made exact, and no more
                remaining.cancelled = incumbent.cancelled
                self._exact(first, remaining, self._exactness(first))
                return 0
            motions, made, round_ = [first], 0, None
            if not (refused or self.request.anytime):
                self._exact_at_once(first, remaining)
                motions, made = self._several(first, remaining)
                round_ = self._most_promising(motions, remaining)
            given = motions[0] if round_ is None else round_.given
            self._refine(given, remaining, round_)
            if given is not first and incumbent.best.goal_distance > CENTRE_TOLERANCE:
                self._refine(first, remaining)  # the longer one may end in the centre
            unmended = refused and incumbent.best.status == REFUSED
            if not (self.request.anytime or unmended):
                made = self._search_again(first, remaining, made)
            if incumbent.time() >= limit and not incumbent.cancelled():
                self._out_of_time = limit
            return made

    def _refine(
        self, given: Trajectory, remaining: Budget, round_: Shortening | None = None
    ) -> None:
        """Shorten a motion and make it exact: what is long and verified first loses its detours.

        Args:
            given: The motion.
            remaining: Of the improvement's work.
            round_: Of shortening it, where that has already begun.
        """
        shortest, solved = given, self._incumbent.best.status == "solved"
        if not (solved and trajopt.is_long(self.problem, given)):
            shortest = self._exact(given, remaining, self._exactness(given))
        while not remaining.over:
            round_ = round_ or Shortening(self._incumbent, shortest, remaining)
            before, shortest = round_.given, round_.until(never_cancelled)
            round_ = None
            if not shortest.duration < (1 - MIN_GAIN) * before.duration:
                break
        if self.problem.goal_distance(shortest.x[-1]) > CENTRE_TOLERANCE:
            end = Budget(self._seconds, clock=remaining.clock, cancelled=self._incumbent.cancelled)
            self._exact(shortest, end, self._exactness(given))
        self._learn(given.duration / shortest.duration)

    def _exactness(self, given: Trajectory) -> float:
        """Return which fraction of the work may make a motion exact that came of a given one."""
        return EXACTNESS_FRACTION if trajopt.is_long(self.problem, given) else 1.0

    def _exact(self, motion: Trajectory, remaining: Budget, fraction: float) -> Trajectory:
        """Return a motion into the goal's centre, or the same one.

        Args:
            motion: The motion.
            remaining: Of the improvement's work.
            fraction: Of that, for this.
        """
        spent = remaining.fraction(fraction)
        exact = self._incumbent.tried(
            lambda: trajopt.make_exact(self.problem, motion, lambda: spent() >= 1.0)
        )
        if exact is None:
            return motion
        self._incumbent.take(exact, "repair")
        return exact

    def _exact_at_once(self, motion: Trajectory, remaining: Budget) -> None:
        """Offer a motion into the goal's centre to whoever stops soon, apart from counted work."""
        if self.problem.goal_distance(motion.x[-1]) <= CENTRE_TOLERANCE:
            return
        with counted_work(apart=True) as own:
            clock = Budget(self._seconds, clock=lambda: own.seconds, cancelled=remaining.cancelled)
            self._exact(motion, clock, EXACTNESS_AT_ONCE_FRACTION)

    def _below(self, k: int, remaining: Budget, below: float) -> Trajectory | None:
        """Return a motion shorter than a duration in [s] that trees below that have found."""
        from kinolab.solve.cost_bound import (  # late: loads compiled trees
            bounded_work,
            cost_bounded,
        )

        searcher = cost_bounded(self.problem, self.searcher)
        if searcher is None:
            return None
        seconds, patience = bounded_work(self.problem, remaining.unspent)
        budget = Budget(
            seconds,
            improve=seconds,
            below=below,
            patience=patience,
            clock=remaining.clock,
            cancelled=remaining.expired,
        )
        return self._found(searcher, BOUNDED_STREAM + k, budget)

    def _several(self, first: Trajectory, remaining: Budget) -> tuple[list[Trajectory], int]:
        """Search for shorter motions; return them, the shortest first, and how many whole searches.

        Trees below the first one's duration are grown first. Improvement keeps the way on which a
        motion goes, and hardly makes a detour several times as long as another way shorter than
        that one.
        """
        work = self._incumbent.search_work
        bounded = self._below(0, remaining, first.duration)
        motions = [first] if bounded is None else [bounded, first]
        searches = min(FIRST_SEARCHES, int(FIRST_FRACTION * remaining.unspent / work))
        if searches < LEAST_FIRST_SEARCHES:
            searches = 0
        for k in range(1, searches + 1):
            end = Budget(FIRST_FACTOR * work, clock=remaining.clock, cancelled=remaining.cancelled)
            shortest = min(motion.duration for motion in motions)
            found = self._searched(k, end, shortest)
            if found is not None:
                motions.append(found)
        motions.sort(key=lambda motion: motion.duration)
        if self._incumbent.beaten_by(motions[0]) and not self._incumbent.take(motions[0], "search"):
            motions = [first]
        elif motions[0] is not first:
            self._exact_at_once(motions[0], remaining)
        return motions, searches

    def _most_promising(
        self, motions: Sequence[Trajectory], remaining: Budget
    ) -> Shortening | None:
        """Shorten the two shortest motions for a while; return what is shorter then, to go on.

        How long a motion is says little of the way on which it goes. None where there is no
        choice, or too little work for it; across transitions nothing is gained before the end.
        """
        work = min(RACE_FRACTION * remaining.unspent, MOST_RACE_SECONDS)
        few = work < RACE_SECONDS_PER_STEP * motions[0].duration / self.problem.step
        if few or self.problem.machine.modes or self._incumbent.best.status != "solved":
            return None
        if len(motions) < 2 or not trajopt.is_long(self.problem, motions[0]):
            return None
        rounds = [Shortening(self._incumbent, motion, remaining) for motion in motions[:2]]
        for one in rounds:
            spent = Budget(work, clock=remaining.clock)
            one.until(spent.expired)
        return min(rounds, key=lambda one: one.best.duration)

    def _another(self, k: int, turn: int, remaining: Budget) -> tuple[Trajectory | None, bool]:
        """Return the motion of a k-th further search, and whether its way may be a shorter one.

        In turn they are guesses, the searcher's, and below a bound, which is longer than the best
        motion by what improvement has gained.

        Args:
            k: Number of the search.
            turn: How many there were after the first motion had been shortened.
            remaining: Of the improvement's work.
        """
        kind = KINDS[turn % len(KINDS)]
        found = self._guessed(k, remaining) if kind == GUESSED else None
        if found is not None:
            return found, True
        if kind == BOUNDED:
            found = self._below(k, remaining, self._gained * self._shortest)
        found = found or self._searched(k, remaining, self._shortest)
        return found, found is not None and self._promises(found.duration)

    def _guessed(self, k: int, remaining: Budget) -> Trajectory | None:
        """Return a motion, of any duration, along a path that is shorter than the best motion."""
        from kinolab.solve.cost_bound import GUESSED_SHARE, guessing  # late: loads compiled trees

        searcher = guessing(self.problem, self.searcher)
        if searcher is None:
            return None
        budget = Budget(
            GUESSED_SHARE * remaining.unspent,
            below=self._shortest,
            clock=remaining.clock,
            cancelled=remaining.expired,
        )
        return self._found(searcher, GUESSED_STREAM + k, budget)

    def _searched(self, k: int, remaining: Budget, below: float) -> Trajectory | None:
        """Search with the k-th further seed for a motion shorter than a duration in [s]."""
        iterations = self._incumbent.best.iterations
        most = SEARCH_FACTOR * iterations + MORE_ITERATIONS
        each = self._incumbent.search_work / max(iterations, 1)
        budget = Budget(
            PATIENCE * self._seconds,
            min(most, int(remaining.unspent / each)),
            improve=0.0,
            below=below,
            cancelled=remaining.expired,  # guesses are work, too
        )
        return self._found(self.searcher, k, budget)

    def _found(self, searcher: AbstractPlanner, k: int, budget: Budget) -> Trajectory | None:
        """Search with the k-th further seed, so that the user can interrupt it."""
        if self.watch:
            self.watch(budget)
        if self._incumbent.cancelled():
            return None  # interrupted before this budget was registered
        self._incumbent.budget = budget
        return motion(self.problem, searcher, stream(self._incumbent.best.seed, k), budget)

    def _search_again(self, first: Trajectory, remaining: Budget, made: int) -> int:
        """Search for motions that may become shorter; return the number of searches.

        Args:
            first: The first search's motion.
            remaining: Of the improvement's work.
            made: Further searches so far.
        """
        last, incumbent = first, self._incumbent
        for k in count(made + 1):
            dear = remaining.unspent < incumbent.search_work
            if remaining.over or dear or incumbent.cancelled():
                self._unfinished = not incumbent.cancelled()
                return k - 1
            found, promising = self._another(k, k - made - 1, remaining)
            if found is None:
                continue
            if np.array_equal(found.u, last.u):
                return k  # the planner is deterministic
            last = found
            incumbent.take(found, "search")
            if promising:
                self._refine(found, remaining)
        raise AssertionError("counting never ends")


def _last_half_gain(gains: Sequence[tuple[float, float]], seconds: float) -> float:
    """Return the fraction by which the second half of the work made the motion shorter.

    Args:
        gains: The work in [s] and the duration in [s] of each verified motion, in order.
        seconds: All of the work.
    """
    first = [duration for work, duration in gains if work <= 0.5 * seconds]
    if not first:
        return 0.0
    return max(0.0, 1.0 - min(duration for _, duration in gains) / min(first))


def _statistics(found: PlanResult, best: PlanResult, further: int) -> dict[str, float]:
    statistics = {"further_searches": float(further)}
    if found.status == "solved" and found.cost is not None:
        statistics["raw_duration"] = found.cost
    if best.trajectory is not None and best.status == "solved":
        statistics["final_duration"] = best.trajectory.duration
        margin = best.certificate.margin if best.certificate else None
        statistics |= {} if margin is None else {"margin": margin.clearance}
    return statistics
