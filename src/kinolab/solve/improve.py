"""After a first motion: made exact, made shorter, and searched for again as long as it may take.

What comes out is never worse than what was found, and each motion that is kept has been verified.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import count

import numpy as np

from kinolab.numerics.compiling import Compilation, compilation
from kinolab.problem import Problem
from kinolab.search import AbstractPlanner, Budget
from kinolab.solve.attempt import motion
from kinolab.solve.incumbent import Keeper
from kinolab.solve.plan import Plan
from kinolab.solve.repeated_search import REFUSED, stream
from kinolab.solve.request import Request
from kinolab.solve.solution_pool import CENTRE
from kinolab.trajectory import Trajectory
from kinolab.trajopt import (
    AbstractAllowance,
    Seconds,
    Spent,
    Subproblems,
    is_long,
    repair,
    shorten,
)

RATE = 40  # subproblems that stand for a second where a search must repeat bit by bit
PART = 0.7  # of what is left for one round of shortening: each one is verified and kept
LANDING = 0.25  # of the time for improving: to make a long motion exact before it is shortened
QUICK = 0.2  # of the time for improving: a verification that does not keep from shortening
GAIN = 1e-3  # share of the duration that is worth another round
MENDING = 0.25  # of the time that is left to search: for a motion that the verifier refuses
SOON = 2.0  # [s] for it in any case


@dataclass
class Improving:
    """Improves the plans of one process or thread.

    Attributes:
        problem: That they solve.
        searcher: That found them, to search again.
        request: How long, and with how many seeds.
        elapsed: Tells the seconds since the first search began.
        watch: Called with the budget of each further search, so that it can be interrupted.
        told: Called with each verified plan that is better than those before with this seed.
    """

    problem: Problem
    searcher: AbstractPlanner
    request: Request
    elapsed: Callable[[], float]
    watch: Callable[[Budget], None] | None = None
    told: Callable[[Plan], None] | None = None
    _shortest: float = math.inf  # [s] of all plans
    _gained: float = 1.0  # the most that a motion's duration was divided by

    def plan(self, found: Plan, budget: Budget) -> Plan:
        """Return the best that can be made of a plan, or the same one.

        Args:
            found: As a search gave it.
            budget: Of that search.
        """
        with compilation() as compiled:
            keeper = Keeper(self.problem, found, budget, self._clock(compiled), self.told)
            keeper.begin()
            if found.trajectory is None or not self._worth_it(found, keeper):
                self._learn(keeper)
                return keeper.plan()
            begun, further = keeper.time(), self._improve(keeper, found.trajectory)
            statistics = self._statistics(found, keeper.best, further)
            return keeper.plan({"improve": keeper.time() - begun}, statistics)

    def _clock(self, compiled: Compilation) -> Callable[[], float]:
        """Return a clock that stands still while anything is compiled."""
        return lambda: self.elapsed() - compiled.seconds

    @property
    def _seconds(self) -> float:
        return self.problem.scenario.planner.improve

    def _worth_it(self, found: Plan, keeper: Keeper) -> bool:
        if not (self.request.optimize and self._seconds) or keeper.stopped:
            return False
        return found.status != "solved" or self._promises(found.cost)

    def _promises(self, duration: float | None) -> bool:
        """Say whether a motion gets shorter than all others if it gains as much as they did."""
        return duration is not None and duration < self._gained * self._shortest

    def _learn(self, keeper: Keeper, gained: float = 1.0) -> None:
        """Take in how short a motion is now, and what one's duration was divided by."""
        if keeper.best.status == "solved" and keeper.best.cost is not None:
            self._shortest = min(self._shortest, keeper.best.cost)
            self._gained = max(self._gained, gained)

    def _improve(self, keeper: Keeper, first: Trajectory) -> int:
        """Improve a motion, and others; return how many more searches were made.

        One that the verifier refuses is mended, if it can be; the caller searches for others.
        """
        refused, limit = keeper.best.status == REFUSED, self.request.time_limit
        seconds = self._seconds
        if refused:  # most of the time is for finding another one
            seconds = min(seconds, max(SOON, MENDING * (limit - keeper.time())))
        end = keeper.time() + seconds
        allowance: AbstractAllowance
        if self.request.max_iterations is not None:
            most = math.ceil(RATE * self._seconds)
            allowance = Subproblems(most, max(end, limit), keeper.time, lambda: keeper.stopped)
        else:
            allowance = Seconds(end, keeper.time, lambda: keeper.stopped)
        self._refine(keeper, first, allowance)
        unmended = refused and keeper.best.status == REFUSED
        if isinstance(allowance, Subproblems) or self.request.anytime or unmended:
            return 0
        return self._search_again(keeper, first, allowance)

    def _refine(self, keeper: Keeper, given: Trajectory, allowance: AbstractAllowance) -> None:
        """Make a motion exact, and shorter as long as there is time."""
        long = is_long(self.problem, given)
        exact = self._exact(keeper, given, allowance.part(LANDING if long else 1.0))
        # A plan that is found late is made exact all the same, but no more than that.
        allowance.until = min(allowance.until, self.request.time_limit)
        at_once = exact is not None and (
            isinstance(allowance, Subproblems) or self._verified_soon(keeper.best)
        )
        if exact is not None and at_once:
            keeper.take(exact, "repair")
        shortest = self._shortened(keeper, exact or given, allowance)
        if exact is None and long and self.problem.goal_distance(shortest.x[-1]) > CENTRE:
            exact = shortest = self._exact(keeper, shortest, allowance.part()) or shortest
            at_once = False
        if exact is not None and shortest is exact and not at_once:
            keeper.take(exact, "repair")
        self._learn(keeper, given.duration / shortest.duration)

    def _exact(self, keeper: Keeper, given: Trajectory, spent: Spent) -> Trajectory | None:
        return keeper.tried(partial(repair, self.problem, given, lambda: spent() >= 1.0))

    def _verified_soon(self, best: Plan) -> bool:
        """Say whether to verify a motion before it is shortened: if that leaves time to do so."""
        return best.status != "solved" or best.timings.get("verify", 0.0) <= QUICK * self._seconds

    def _shortened(
        self, keeper: Keeper, given: Trajectory, allowance: AbstractAllowance
    ) -> Trajectory:
        """Return the shortest verified motion that came of an exact one, or that one itself.

        Where verifying takes so long that no second round would follow, the first one takes all.
        """
        part = PART if self._verified_soon(keeper.best) else 1.0
        while not allowance.over:
            shorter = keeper.tried(partial(shorten, self.problem, given, allowance.part(part)))
            if shorter is None or not shorter.duration < given.duration:
                break
            worth_another = shorter.duration < given.duration * (1 - GAIN)
            if keeper.take(shorter, "shorten"):
                given = shorter
            if given is not shorter or not worth_another:
                break
        return given

    def _search_again(self, keeper: Keeper, first: Trajectory, allowance: AbstractAllowance) -> int:
        """Search for motions that may become shorter, and return how often."""
        seed, last = keeper.best.seed, first
        for k in count(1):
            if allowance.left < keeper.budget.prepared or allowance.over:
                return k - 1
            budget = Budget(allowance.left, improve=0.0, below=self._shortest)
            if self.watch:
                self.watch(budget)
            if keeper.stopped:
                return k - 1  # that was meant for this search, which was not known yet
            keeper.budget = budget
            found = motion(self.problem, self.searcher, stream(seed, k), budget)
            if found is None:
                continue
            if np.array_equal(found.u, last.u):
                return k  # nothing in this planner is drawn at random
            last = found
            if self._promises(found.duration):
                self._refine(keeper, found, allowance)
        raise AssertionError("counting never ends")

    def _statistics(self, found: Plan, best: Plan, further: int) -> dict[str, float]:
        statistics = {"further_searches": float(further)}
        if found.status == "solved" and found.cost is not None:
            statistics["raw_duration"] = found.cost
        if best.trajectory is not None and best.status == "solved":
            statistics["final_duration"] = best.trajectory.duration
            margin = best.certificate.margin if best.certificate else None
            statistics |= {} if margin is None else {"margin": margin.room}
        return statistics
