"""A plan that costs less by [objective], made of the quickest one: its duration is free.

Searches and the improvement before are those of the same problem without an objective, so that what
is made here is never dearer than the quickest plan that is known; only planners that compare costs
search for what costs little.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from kinolab import trajopt
from kinolab.numerics.work import counted_work
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget
from kinolab.simulation.reference import price
from kinolab.solve.improve import LEAST_SECONDS, MOST_SECONDS, PATIENCE, SEARCHES_PER_WAY
from kinolab.solve.incumbent import AT_ONCE, Incumbent
from kinolab.solve.plan import REFUSED, PlanResult, Request
from kinolab.solve.refinement import STILL_GAINING
from kinolab.solve.starts import Starts
from kinolab.trajectory import Trajectory
from kinolab.verification import verify


@dataclass
class Cheapening:
    """Makes quick plans cost less.

    Attributes:
        problem: The planning problem, with an [objective].
        timed: The same without.
        searcher: The planner, to search again.
        request: Time limit and options.
        elapsed: Returns the seconds since the first search began.
        on_improved: Called with each verified plan that costs less than those before.
    """

    problem: PlanningTask
    timed: PlanningTask
    searcher: AbstractPlanner
    request: Request
    elapsed: Callable[[], float]
    on_improved: Callable[[PlanResult], None] | None = None

    def plan(self, found: PlanResult, quick: PlanResult, budget: Budget) -> PlanResult:
        """Return the plan that costs least of those that are made of a quick one, itself included.

        Args:
            found: What the search found.
            quick: The plan that improvement made of it.
            budget: The budget of that search.
        """
        if quick.status != "solved" or quick.trajectory is None:
            return quick
        incumbent = Incumbent(
            self.problem, self._priced(quick), budget, self.elapsed, self.on_improved
        )
        incumbent.begin()
        if found.trajectory is not None and incumbent.improvements:
            first = replace(quick.improvements[0], price=price(self.problem, found.trajectory))
            incumbent.improvements.insert(0, first)
            incumbent.take(found.trajectory, "search")
        begun, seconds = incumbent.time(), quick.statistics.get("improvement_seconds", 0.0)
        auto = self.request.effort(self.problem) == "auto"
        if seconds and auto:
            seconds = max(seconds, SEARCHES_PER_WAY * LEAST_SECONDS)
        gain, unfinished = 0.0, False
        if seconds:
            patience = min(PATIENCE * seconds, self.request.time_limit - begun)
            with counted_work() as work:
                remaining = Budget(
                    seconds,
                    clock=lambda: work.seconds,
                    cancelled=lambda: incumbent.cancelled() or incumbent.time() - begun > patience,
                )
                starts = Starts(replace(incumbent, problem=self.timed), self.searcher, remaining)
                gain = self._cheapen(incumbent, [quick.trajectory], starts)
                while auto and gain >= STILL_GAINING and seconds < MOST_SECONDS:
                    more = min(seconds, MOST_SECONDS - seconds)
                    seconds, patience = seconds + more, patience + PATIENCE * more
                    patience = min(patience, self.request.time_limit - begun)
                    remaining.time_limit += more
                    assert incumbent.best.trajectory is not None
                    gain = self._cheapen(incumbent, [incumbent.best.trajectory], starts)
                unfinished = remaining.over and not incumbent.cancelled()
        best, limit = incumbent.best, self.request.time_limit
        statistics = {
            "improvement_unfinished": float(unfinished),
            "improvement_out_of_time": limit if incumbent.time() >= limit else 0.0,
            "improvement_seconds": seconds,
            "last_half_gain": gain,
        }
        if best.status == "solved" and best.duration is not None:
            statistics["final_duration"] = best.duration
        return incumbent.plan({"cheapen": incumbent.time() - begun}, statistics)

    def _priced(self, quick: PlanResult) -> PlanResult:
        """Return a plan with what it costs, held against all that the problem asks."""
        assert quick.trajectory is not None
        certificate = verify(self.problem, quick.trajectory)
        status = quick.status if certificate.passed else REFUSED
        cost = price(self.problem, quick.trajectory)
        return replace(quick, status=status, certificate=certificate, price=cost)

    def _cheapen(self, incumbent: Incumbent, motions: list[Trajectory], starts: Starts) -> float:
        """Make motions cost less, then those of further searches; return what part that saves."""
        before = incumbent.best.price or 0.0
        remaining, longest = starts.remaining, trajopt.most_time(self.problem)
        while not (incumbent.cancelled() or starts.exhausted or remaining.over):
            given, motions = motions[:AT_ONCE], motions[AT_ONCE:]
            # of the work that is left, for each motion that is made to cost less
            seconds, forks = 0.6 * remaining.unspent, []
            for motion in given:
                own = incumbent.apart()
                forks.append(own.forked(partial(_cheapen, own), alone=len(given) == 1))
                forks[-1].ask((motion, seconds))
            try:
                incumbent.joined(forks)
            finally:
                for fork in forks:
                    fork.end()
            motions = motions or [start.motion for _, start in starts.others(longest)]
        return 1.0 - (incumbent.best.price or 0.0) / before if before else 0.0


def _cheapen(own: Incumbent, motion: Trajectory, seconds: float) -> None:
    """Offer motions that cost less than one from which they are made, for so much work in [s]."""
    budget = Budget(seconds, clock=lambda: own.clock.seconds, cancelled=own.cancelled)
    for cheaper in trajopt.cheapened(own.problem, motion, budget.spent):
        own.take(cheaper, "cheapen")
