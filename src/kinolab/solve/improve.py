"""Plan improvement after a first solution: exact and shorter motions on several ways.

The result is never worse than the first solution, and every incumbent has been verified. How long a
motion is says little of how short it can become on its way, so that work is given by *sequential
halving*: with n motions, log2 n + 1 rounds take equal parts of the work, and after each the shorter
half goes on. What is left is for further starts, as long as they may be expected to gain something.

Sources: Karnin, Koren, Somekh, Almost optimal exploration in multi-armed bandits, ICML 2013;
Jamieson, Talwalkar, Non-stochastic best arm identification, AISTATS 2016.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from kinolab import trajopt
from kinolab.numerics.compiling import compilation
from kinolab.numerics.work import counted_work
from kinolab.problem import PlanningTask
from kinolab.scenario import Effort, improvement_seconds
from kinolab.search import AbstractPlanner, Budget
from kinolab.solve.incumbent import Incumbent
from kinolab.solve.plan import CENTRE_TOLERANCE, REFUSED, PlanResult, Request
from kinolab.solve.refinement import Refinement
from kinolab.solve.starts import Starts
from kinolab.trajectory import Trajectory

# of the time limit, for repairing a motion that the verifier rejects
REPAIR_TIME_FRACTION = 0.1
MIN_REPAIR_SECONDS = 2.0  # [s] for that at least
# Where nobody says how much work improvement may take, a motion of more steps than this gets more
# in proportion, so many times as much at most.
SHORT_MOTION, MAX_GROWTH = 200, 5.0
PATIENCE = 8.0  # times as many seconds by the clock may the improvement take, on a busy computer
# So many motions are searched for where one can be shortened, as far as this fraction of the work
# pays for them: a search is cheap beside shortening.
SEARCHES_PER_WAY, SEARCH_FRACTION = 4, 0.15
SECONDS_PER_STEP = 4e-3  # [s] of shortening that show something, for each of a motion's steps
ALIKE = 0.1  # fraction by which least durations of ways on the same side may differ
MIN_EXPECTED_GAIN = 0.01  # of the duration, by further starts, to go on
MIN_WAYS = 3  # whose spread says something


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
        """Improve a motion and those of further searches; return the number of searches.

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
                Refinement(incumbent, first, remaining).end()
                return 0
            starts = Starts(incumbent, self.searcher, remaining, self.watch)
            alone = refused or self.request.anytime
            ways = self._halved([first] if alone else self._several(first, starts), remaining)
            if ways[-1].given is not first and incumbent.best.goal_distance > CENTRE_TOLERANCE:
                self._finish(Refinement(incumbent, first, remaining))  # it may end in the centre
            unmended = refused and incumbent.best.status == REFUSED
            if not (self.request.anytime or unmended):
                self._start_again(starts, ways)
            if incumbent.time() >= limit and not incumbent.cancelled():
                self._out_of_time = limit
            return starts.made

    def _several(self, first: Trajectory, starts: Starts) -> list[Trajectory]:
        """Return motions to shorten, the shortest first: as many as can then be told apart.

        Trees below the first one's duration are grown first: improvement hardly makes a detour
        several times as long as another way shorter than that one.
        """
        remaining, work, incumbent = starts.remaining, self._incumbent.search_work, self._incumbent
        Refinement(incumbent, first, remaining).offer_exact()
        found = [first, starts.bounded(0, first.duration) or first]
        ways, enough = 1, work + SECONDS_PER_STEP * first.duration / self.problem.step
        while remaining.unspent >= 2 * ways * (math.log2(2 * ways) + 1) * enough:
            ways *= 2
        guess = None
        if remaining.unspent >= 2 * enough:  # else it would leave too little for shortening
            guess = starts.guessed(0, found[-1].duration)
        most = int(SEARCH_FRACTION * remaining.unspent / work)
        while starts.made < min(SEARCHES_PER_WAY * ways, most):
            starts.made += 1
            shortest = min(motion.duration for motion in found)
            found.append(starts.searched(starts.made, shortest) or first)
        motions = sorted({id(one): one for one in found}.values(), key=lambda one: one.duration)
        if guess is not None:
            motions = self._on_short_ways([motions[0], guess])
        if motions[0] is first:
            return motions[:ways]
        if incumbent.beaten_by(motions[0]) and not incumbent.take(motions[0], "search"):
            return [first]
        Refinement(incumbent, motions[0], remaining).offer_exact()
        return motions[:ways]

    def _on_short_ways(self, motions: list[Trajectory]) -> list[Trajectory]:
        """Return motions whose ways are about as short as the shortest one, by their durations."""
        ways = trajopt.least_durations(self.problem, motions)
        shortest = (1.0 + ALIKE) * min(ways)
        short = [motion for motion, way in zip(motions, ways, strict=True) if way <= shortest]
        return sorted(short, key=lambda motion: motion.duration)

    def _halved(self, motions: Sequence[Trajectory], remaining: Budget) -> list[Refinement]:
        """Shorten motions by sequential halving; return all of them, the shortest last."""
        left = [Refinement(self._incumbent, motion, remaining) for motion in motions]
        dropped: list[Refinement] = []
        rounds, work = math.log2(len(left)) + 1, remaining.unspent
        while len(left) > 1:
            for way in left:
                way.go_on(Budget(work / rounds / len(left), clock=remaining.clock).expired)
            left.sort(key=lambda way: way.shortest.duration)
            half = (len(left) + 1) // 2
            left, dropped = left[:half], [*left[half:], *dropped]
        self._finish(left[0])
        return [*dropped, left[0]]

    def _finish(self, way: Refinement) -> None:
        """Shorten a motion to the end, and make it end in the goal's centre."""
        way.go_on()
        way.end()
        self._learn(way.given.duration / way.shortest.duration)

    def _start_again(self, starts: Starts, ways: list[Refinement]) -> None:
        """Improve motions of further searches while they may be expected to gain something.

        Each is given up where it is longer than the best way's motion was after as much work.
        """
        incumbent, remaining = self._incumbent, starts.remaining
        while not (incumbent.cancelled() or starts.exhausted):
            if remaining.over or remaining.unspent < incumbent.search_work:
                self._unfinished = not incumbent.cancelled()
                return
            if _expected_gain(ways, remaining) < MIN_EXPECTED_GAIN:
                return
            best, before, starts.gained = ways[-1], self._shortest, self._gained
            arm, found = starts.another(before)
            if found is None or starts.exhausted:
                continue
            incumbent.take(found, "search")
            if not (arm.any_length or self._promises(found.duration)):
                continue
            way = Refinement(incumbent, found, remaining)
            way.race(best, SECONDS_PER_STEP * found.duration / self.problem.step)
            if way.over:
                self._finish(way)
            won = self._shortest < before  # verified
            arm.rewards += won
            ways.insert(len(ways) if won else 0, way)


def _expected_gain(ways: Sequence[Refinement], remaining: Budget) -> float:
    """Return the fraction by which further starts may be expected to shorten the best motion.

    The shortest of n durations, drawn alike, is expected to be beaten by one of m more with
    probability m / (n + m), and by as much as it is below the second (Robson, Whitlock, Estimation
    of a truncation point, Biometrika 51, 1964). A way that was given up counts as if it had
    gone on as the best one.

    Args:
        ways: The best is the last.
        remaining: Budget of the work, of which all ways together took what is spent.
    """
    if len(ways) < MIN_WAYS:
        return math.inf
    best, n = ways[-1], len(ways)
    second = min(way.shortest.duration / best.duration_at(way.work) for way in ways[:-1])
    more = remaining.unspent * n / remaining.elapsed
    return more / (n + more) * abs(second - 1.0)


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
