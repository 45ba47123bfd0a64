"""Further searches for motions to improve: the arms among which improvement chooses."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from kinolab import trajopt
from kinolab.concurrency.cancel import CancelledError
from kinolab.search import AbstractPlanner, Budget
from kinolab.solve.attempt import motion
from kinolab.solve.incumbent import AT_ONCE, Incumbent
from kinolab.solve.plan import stream
from kinolab.trajectory import Trajectory

# A further search may take this many times the first one's iterations, and some more.
SEARCH_FACTOR, MORE_ITERATIONS = 2, 200
# added to the number of a search by guesses, or below a bound: other random numbers
GUESSED_STREAM, BOUNDED_STREAM = 20_000, 10_000

Search: TypeAlias = Callable[["Starts", int, float], Trajectory | None]


@dataclass(frozen=True, eq=False)
class Start:
    """A motion to shorten.

    Attributes:
        motion: As it was found.
        least: About how long motions on its way take at least, in [s].
    """

    motion: Trajectory
    least: float


@dataclass
class Arm:
    """A kind of search, and what its motions were worth.

    Attributes:
        search: Takes a number that chooses random numbers, and a duration in [s] below which a
            motion is wanted; returns a motion, of whatever duration, or None.
        pulls: How often it was used.
        rewards: How often the best plan came of it.
    """

    search: Search
    pulls: int = 0
    rewards: int = 0

    def confidence(self, pulls: int) -> float:
        """Return the upper confidence bound of its reward after so many pulls of all arms.

        Source: Auer, Cesa-Bianchi, Fischer, Finite-time analysis of the multiarmed bandit problem,
        Machine Learning 47, 2002 (UCB1).
        """
        if not self.pulls:
            return math.inf
        return self.rewards / self.pulls + math.sqrt(2.0 * math.log(pulls) / self.pulls)


@dataclass
class Starts:
    """Motions of further searches, with other random numbers.

    Attributes:
        incumbent: The best plan, whose searches are watched and interrupted.
        searcher: The planner.
        remaining: Budget of the improvement's work.
        made: Number of searches so far.
        gained: Factor by which motions may become shorter: as much longer may trees begin.
        exhausted: Whether the planner finds the same motion again and again: it is deterministic.
    """

    incumbent: Incumbent
    searcher: AbstractPlanner
    remaining: Budget
    made: int = 0
    exhausted: bool = False
    gained: float = 1.0
    _last: Trajectory | None = None
    arms: list[Arm] = field(init=False)

    def __post_init__(self) -> None:
        self._last = self.incumbent.best.trajectory
        self.arms = [
            Arm(Starts.guessed),
            Arm(Starts.searched),
            Arm(Starts.bounded),
        ]

    def others(self, below: float) -> list[tuple[Arm, Start]]:
        """Search at once by the most promising arms for motions below a duration in [s]."""
        chosen: list[Arm] = []
        for _ in range(AT_ONCE):
            pulls = sum(arm.pulls for arm in self.arms)
            chosen.append(max(self.arms, key=lambda arm: arm.confidence(pulls)))  # the first
            chosen[-1].pulls += 1
        kinds = [(arm.search, self.made + 1 + k) for k, arm in enumerate(chosen)]
        self.made += AT_ONCE
        found = []
        searches = self.at_once(kinds, below, fall_back=True)
        for arm, start in zip(chosen, searches, strict=False):
            if start is not None:
                last, self._last = self._last, start.motion
                self.exhausted |= last is not None and np.array_equal(start.motion.u, last.u)
                found.append((arm, start))
        return found

    def at_once(
        self, kinds: Sequence[tuple[Search, int]], below: float, *, fall_back: bool = False
    ) -> list[Start | None]:
        """Search at once in several ways, and see how long these are.

        Args:
            kinds: Of each search, and a number that chooses its random numbers.
            below: Duration in [s] below which a motion is wanted.
            fall_back: Whether to search with the planner where a kind finds none.

        Returns:
            What each of them found; nothing after an interrupt by the user.
        """

        def search(own: Incumbent, dealt: Sequence[tuple[Search, int]]) -> list[Start | None]:
            return [self._apart(own, kind, k, below, fall_back) for kind, k in dealt]

        n = min(AT_ONCE, len(kinds))
        forks = []
        for k in range(n):
            own = self.incumbent.apart()
            forks.append(own.forked(partial(search, own), alone=n == 1))
            forks[-1].ask((kinds[k::n],))
        try:
            found = self.incumbent.joined(forks)
        finally:
            for fork in forks:
                fork.end()
        return [] if found is None else [found[k % n][k // n] for k in range(len(kinds))]

    def _apart(
        self, own: Incumbent, kind: Search, k: int, below: float, fall_back: bool
    ) -> Start | None:
        """Search with as much work as is left now, whatever others do meanwhile."""
        remaining = Budget(
            self.remaining.unspent,
            clock=lambda: own.clock.seconds,
            cancelled=self.remaining.cancelled,
        )
        starts = replace(self, incumbent=own, remaining=remaining)
        found = kind(starts, k, below)
        found = starts.searched(k, below) if found is None and fall_back else found
        return None if found is None else Start(found, starts.least_duration(found))

    def least_duration(self, motion: Trajectory) -> float:
        """Return about how long motions on the way of one take at least, in [s].

        Its own duration where modes, which no shortcut crosses, make the way.
        """
        problem = self.incumbent.problem
        if problem.machine.modes:
            return motion.duration
        with suppress(CancelledError):
            return trajopt.least_duration(problem, motion, self.remaining.expired)
        return motion.duration

    def searched(self, k: int, below: float) -> Trajectory | None:
        """Search with the planner and its k-th further seed."""
        best, work = self.incumbent.best, self.incumbent.search_work
        most = SEARCH_FACTOR * best.iterations + MORE_ITERATIONS
        affordable = int(self.remaining.unspent * max(best.iterations, 1) / work)
        budget = Budget(
            math.inf,
            min(most, affordable),
            improve=0.0,
            below=below,
            cancelled=self.remaining.expired,  # guesses are work, too
        )
        return self._found(self.searcher, k, budget)

    def bounded(self, k: int, below: float) -> Trajectory | None:
        """Grow trees below a duration in [s]."""
        from kinolab.solve.cost_bound import bounded_work, cost_bounded  # late: compiled trees

        searcher = cost_bounded(self.incumbent.problem, self.searcher)
        if searcher is None:
            return None
        seconds, patience = bounded_work(self.incumbent.problem, self.remaining.unspent)
        budget = Budget(
            seconds,
            improve=seconds,
            below=self.gained * below,
            patience=patience,
            clock=self.remaining.clock,
            cancelled=self.remaining.expired,
        )
        return self._found(searcher, BOUNDED_STREAM + k, budget)

    def guessed(self, k: int, below: float) -> Trajectory | None:
        """Optimise guesses along paths that are shorter than a duration in [s]."""
        from kinolab.solve.cost_bound import GUESSED_SHARE, guessing  # late: compiled trees

        searcher = guessing(self.incumbent.problem, self.searcher)
        if searcher is None:
            return None
        budget = Budget(
            GUESSED_SHARE * self.remaining.unspent,
            below=below,
            clock=self.remaining.clock,
            cancelled=self.remaining.expired,
        )
        return self._found(searcher, GUESSED_STREAM + k, budget)

    def _found(self, searcher: AbstractPlanner, k: int, budget: Budget) -> Trajectory | None:
        """Search with the k-th further seed; the budget asks whether the user has interrupted."""
        incumbent = self.incumbent
        return motion(incumbent.problem, searcher, stream(incumbent.best.seed, k), budget)
