"""Plan improvement after a first solution: exact and shorter motions on several ways.

The result is never worse than the first solution, and every incumbent has been verified. How long a
motion is says little of how short it can become on its way, so that work is given by *sequential
halving*: with n motions, log2 n rounds take equal parts of the work, and after each but the last
the shorter half goes on; two are shortened to the end, at once where there are two processors. What
is left is for further starts, as long as they may be expected to gain something.

Sources: Karnin, Koren, Somekh, Almost optimal exploration in multi-armed bandits, ICML 2013;
Jamieson, Talwalkar, Non-stochastic best arm identification, AISTATS 2016.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from kinolab import trajopt
from kinolab.numerics.compiling import compilation
from kinolab.numerics.work import counted_work
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget
from kinolab.solve.incumbent import AT_ONCE, Incumbent
from kinolab.solve.plan import CENTRE_TOLERANCE, REFUSED, PlanResult, Request
from kinolab.solve.refinement import STILL_GAINING, RefinedWay, Refinement
from kinolab.solve.starts import Arm, Start, Starts
from kinolab.trajectory import Trajectory

# Where nobody says how much work improvement may take: that of so many subproblems of the whole
# motion, at least and at most so many seconds, which is how long users are ready to wait.
SUBPROBLEMS, LEAST_SECONDS, MOST_SECONDS = 60, 2.0, 30.0
PATIENCE = 16.0  # times as many seconds by the clock may it take: on a busy computer, in turn
# So many motions are searched for where one can be shortened, as far as this fraction of the work
# pays for them: a search is cheap beside shortening.
SEARCHES_PER_WAY, SEARCH_FRACTION = 4, 0.15
SHOWING = 40  # subproblems of a whole motion that show what becomes of it
# Exponent of a motion's first duration beside that of its way: one half as long outweighs a way
# that is longer by 19 %: of machines that slip or roll, which cannot follow it, that says more.
FIRST_COUNTS = 0.25
MIN_WAYS = 3  # whose spread says something


@dataclass
class PlanImprover:
    """Improves the plans of one process or thread.

    Attributes:
        problem: The planning problem.
        searcher: The planner, to search again.
        request: Time limit, seeds and options.
        elapsed: Returns the seconds since the first search began.
        on_improved: Called with each verified plan that is better than those before with this seed.
    """

    problem: PlanningTask
    searcher: AbstractPlanner
    request: Request
    elapsed: Callable[[], float]
    on_improved: Callable[[PlanResult], None] | None = None
    _incumbent: Incumbent = field(init=False)  # of the plan that is being improved
    _shortest: float = math.inf  # [s] of all plans
    _unfinished: bool = False  # whether more work might give a shorter motion
    _out_of_time: float = 0.0  # [s] the time limit, where it ended an improvement
    _gained: float = 1.0  # largest factor by which a duration was reduced
    _seconds: float = 0.0  # [s] of work on the plan
    _subproblem: float = 0.0  # [s] of that for one subproblem of the whole motion
    _done: float = 0.0  # [s] of work on motions, when they were last given more
    _last_half_gain: float = 0.0  # fraction by which the second half of it made a motion shorter

    def plan(self, found: PlanResult, budget: Budget) -> PlanResult:
        """Return an improved plan, or the same one.

        Args:
            budget: The budget of that search.
        """
        with compilation() as compiled:
            incumbent = self._incumbent = Incumbent(
                self.problem,
                found,
                budget,
                lambda: self.elapsed() - compiled.seconds,  # compilation does not count
                self.on_improved,
            )
            incumbent.begin()
            effort = self.request.optimize and self.request.effort(self.problem)
            wanted = effort and not incumbent.cancelled()
            promises = found.status != "solved" or self._promises(found.duration)
            if found.trajectory is None or not (wanted and promises):
                self._learn()
                return incumbent.plan()
            self._seconds = self._work_for(found.trajectory)
            begun, further = incumbent.time(), self._improve(found.trajectory)
            statistics = _statistics(found, incumbent.best, further)
            statistics["improvement_unfinished"] = float(self._unfinished)
            statistics["improvement_out_of_time"] = self._out_of_time
            statistics["improvement_seconds"] = self._seconds  # of work that it was allowed
            statistics["last_half_gain"] = self._last_half_gain
            return incumbent.plan({"improve": incumbent.time() - begun}, statistics)

    def _work_for(self, found: Trajectory) -> float:
        """Return the work on a motion, in [s]."""
        self._subproblem = trajopt.subproblem_seconds(self.problem, found)
        wanted = self.request.effort(self.problem)
        if wanted != "auto":
            return wanted
        return min(max(SUBPROBLEMS * self._subproblem, LEAST_SECONDS), MOST_SECONDS)

    def _promises(self, duration: float | None) -> bool:
        """Say whether a motion would beat all others if it gained as much as they did."""
        return duration is not None and duration < self._gained * self._shortest

    def _learn(self, gained: float = 1.0) -> None:
        """Update the shortest duration and the largest reduction factor."""
        best = self._incumbent.best
        if best.status == "solved" and best.duration is not None:
            self._shortest = min(self._shortest, best.duration)
            self._gained = max(self._gained, gained)

    def _improve(self, first: Trajectory) -> int:
        """Improve a motion and those of further searches; return the number of searches.

        A rejected motion is repaired if possible; otherwise the caller searches again.
        """
        self._unfinished, self._out_of_time, incumbent = False, 0.0, self._incumbent
        self._done = 0.0
        refused, limit = incumbent.best.status == REFUSED, self.request.time_limit
        seconds, begun = self._seconds, incumbent.time()
        if refused:  # most of the time is for another search
            # of the time limit, for repairing a motion that the verifier rejects
            seconds = min(seconds, max(2.0, 0.1 * limit))  # [s] for that at least

        def cancelled() -> bool:
            patience = min(PATIENCE * remaining.time_limit, limit - begun)
            return incumbent.cancelled() or incumbent.time() - begun > patience

        with counted_work() as work:
            remaining = Budget(seconds, clock=lambda: work.seconds, cancelled=cancelled)
            if begun >= limit:  # a plan found late is made exact, and no more
                remaining.cancelled = incumbent.cancelled
                Refinement(incumbent, first, remaining).end()
                return 0
            starts = Starts(incumbent, self.searcher, remaining)
            given = Start(first, first.duration)
            alone = refused or self.request.anytime
            ways = self._halved([given] if alone else self._several(first, starts), remaining)
            if not ways:  # interrupted
                return starts.made
            self._last_half_gain = ways[-1].progress.last_half_gain
            other = ways[-1].given.motion is not first
            if other and incumbent.best.goal_distance > CENTRE_TOLERANCE:
                self._finish([RefinedWay(incumbent, given, remaining, alone=True)], remaining)
            unmended = refused and incumbent.best.status == REFUSED
            if not (self.request.anytime or unmended):
                self._start_again(starts, ways)
            if incumbent.time() >= limit and not incumbent.cancelled():
                self._out_of_time = limit
            return starts.made

    def _several(self, first: Trajectory, starts: Starts) -> list[Start]:
        """Return motions to shorten, as many as can then be told apart: those on the shortest ways.

        How long a motion is at first says little of how short it can become; how long its way is
        when it is pulled tight says much, if not of machines that cannot go sideways. Trees below
        the first one's duration are grown first.
        """
        remaining, incumbent = starts.remaining, self._incumbent
        exact, before = Refinement(incumbent, first, remaining).offered_exact(), remaining.elapsed
        given = Start(exact, starts.least_duration(exact))
        searching = incumbent.search_work + remaining.elapsed - before
        ways, enough = AT_ONCE, SHOWING * self._subproblem
        # of the work, which searches leave to shortening at least, about
        while 0.6 * remaining.unspent >= ways * math.log2(2 * ways) * enough:
            ways *= 2  # half of them on each line
        affordable = int(SEARCH_FRACTION * remaining.unspent * AT_ONCE / searching)
        most = min(affordable, SEARCHES_PER_WAY * ways)
        # A guess takes as long as a search, and is worth nothing that nobody has time to shorten.
        guessing = remaining.unspent >= 2 * (searching + enough)
        kinds = [(Starts.bounded, 0), *([(Starts.guessed, 0)] if guessing else [])]
        kinds += [(Starts.searched, k) for k in range(1, most + 1)]
        starts.made = most
        found = starts.at_once(kinds, exact.duration)
        if not found:
            return []
        several = [given, *(start for start in found if start is not None)]
        shortest = min(several, key=lambda start: start.motion.duration)
        if shortest is not given:
            several.remove(shortest)
            motion = shortest.motion
            if not incumbent.beaten_by(motion) or incumbent.take(motion, "search"):
                exact = Refinement(incumbent, motion, remaining).offered_exact()
                several.append(replace(shortest, motion=exact))
        return _most_promising(several)[:ways]

    def _halved(self, starts: Sequence[Start], remaining: Budget) -> list[RefinedWay]:
        """Shorten motions by sequential halving; return all of them, the shortest last."""
        if not starts:
            return []
        numbers = [len(starts)]
        while numbers[-1] > AT_ONCE:
            numbers.append((numbers[-1] + 1) // 2)
        # of the work, in each round
        parts = [min(1.0, AT_ONCE / number) / len(numbers) for number in numbers]
        work, until = remaining.unspent, 0.0
        left = [
            RefinedWay(self._incumbent, start, remaining, sum(parts), alone=len(starts) == 1)
            for start in starts
        ]
        dropped: list[RefinedWay] = []
        try:
            for number, part in zip(numbers[1:], parts, strict=False):
                until += part * work
                if not self._joined(left, Refinement.go_on, until):
                    break
                left.sort(key=lambda way: way.duration)
                dropped = [*left[number:], *dropped]
                left = left[:number]
                for way in dropped:
                    way.end()
            self._finish(left, remaining)
            while self._goes_on(left, remaining):
                self._finish(left, remaining)
        finally:
            for way in left:
                way.end()
        return [*dropped, *sorted(left, key=lambda way: -way.duration)]

    def _goes_on(self, ways: Sequence[RefinedWay], remaining: Budget) -> bool:
        """Allow as much work again while the shortest motion gets shorter, or has not begun to."""
        best = min(ways, key=lambda way: way.duration).progress
        done, self._done = self._done, sum(way.progress.work for way in ways)
        # else nothing came of the last time
        return self._done > done and self._has_more_work(best.expected_gain, remaining)

    def _has_more_work(self, gain: float, remaining: Budget) -> bool:
        """Allow as much work again if it may be expected to gain so large a fraction."""
        more = min(self._seconds, MOST_SECONDS - self._seconds)
        auto = self.request.effort(self.problem) == "auto"
        if not auto or gain < STILL_GAINING or more <= 0.0 or remaining.cancelled():
            return False
        self._seconds += more
        remaining.time_limit += more
        return True

    def _joined(self, ways: Sequence[RefinedWay], *question: object) -> bool:
        """Ask all ways to do something at once, and wait for them; say whether they did it."""
        for way in ways:
            way.fork.ask(question)
        made = self._incumbent.joined([way.fork for way in ways])
        for way, progress in zip(ways, made or (), strict=False):
            way.progress = progress
        return made is not None

    def _finish(self, ways: Sequence[RefinedWay], remaining: Budget) -> None:
        """Shorten motions to the end, and make them end in the goal's centre."""
        self._joined(ways, Refinement.finish, remaining.unspent)
        for way in ways:
            self._learn(way.given.motion.duration / way.duration)

    def _start_again(self, starts: Starts, ways: list[RefinedWay]) -> None:
        """Improve motions of further searches while they may be expected to gain something.

        Each is given up where it is longer than the best way's motion was after as much work.
        """
        incumbent, remaining = self._incumbent, starts.remaining
        while not (incumbent.cancelled() or starts.exhausted):
            if remaining.over or remaining.unspent < incumbent.search_work:
                if len(ways) < MIN_WAYS and self._has_more_work(1.0, remaining):
                    continue
                self._unfinished = not incumbent.cancelled()
                return
            # of the duration, by further starts, to go on
            if _expected_gain(ways, remaining) < 0.01:
                return
            starts.gained = self._gained
            # In proportion to what it takes when pulled tight, no way is shorter than the best.
            longest = self._shortest * max(way.given.least / way.duration for way in ways)
            found = starts.others(self._shortest)
            for _, start in found:
                incumbent.take(start.motion, "search")
            found = [(arm, start) for arm, start in found if start.least < longest]
            alone = len(found) == 1
            new = [
                (arm, RefinedWay(incumbent, start, remaining, alone=alone)) for arm, start in found
            ]
            self._race(new, ways, remaining)

    def _race(
        self, new: list[tuple[Arm, RefinedWay]], ways: list[RefinedWay], remaining: Budget
    ) -> None:
        """Shorten further motions while they may beat the best one; then that one to the end."""
        best, racing = ways[-1].progress, [way for _, way in new]
        until, showing = remaining.unspent, SHOWING * self._subproblem
        try:
            self._joined(racing, Refinement.go_on, until, best, showing)
            for arm, way in sorted(new, key=lambda one: one[1].duration):
                before = self._shortest
                if way.progress.over or way.duration < best.shortest.duration:
                    self._finish([way], remaining)
                won = self._shortest < before  # verified
                arm.rewards += won
                ways.insert(len(ways) if won else 0, way)
        finally:
            for _, way in new:
                way.end()


def _most_promising(starts: Sequence[Start]) -> list[Start]:
    """Return motions, the most promising first: on short ways, and among those the short ones."""
    return sorted(starts, key=lambda start: start.least * start.motion.duration**FIRST_COUNTS)


def _expected_gain(ways: Sequence[RefinedWay], remaining: Budget) -> float:
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
    best, n = ways[-1].progress, len(ways)
    second = min(way.duration / best.duration_at(way.progress.work) for way in ways[:-1])
    more = remaining.unspent * n / remaining.elapsed
    return more / (n + more) * abs(second - 1.0)


def _statistics(found: PlanResult, best: PlanResult, further: int) -> dict[str, float]:
    statistics = {"further_searches": float(further)}
    if found.status == "solved" and found.duration is not None:
        statistics["raw_duration"] = found.duration
    if best.trajectory is not None and best.status == "solved":
        statistics["final_duration"] = best.trajectory.duration
        margin = best.certificate.margin if best.certificate else None
        statistics |= {} if margin is None else {"margin": margin.clearance}
    return statistics
