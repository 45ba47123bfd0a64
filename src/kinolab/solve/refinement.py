"""A motion that improvement makes exact and shorter and shorter, for as long as its work pays.

Improvement keeps the way on which a motion goes round obstacles, so that several motions, which
may go on different ways, are each improved for a while.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from kinolab import trajopt
from kinolab.concurrency.cancel import never_cancelled
from kinolab.concurrency.coroutine import Coroutine
from kinolab.numerics.work import counted_work
from kinolab.search import Budget
from kinolab.solve.incumbent import Incumbent
from kinolab.solve.plan import CENTRE_TOLERANCE
from kinolab.solve.starts import Start
from kinolab.trajectory import Trajectory

# of a motion's work, to make it exact before it is shortened, or after that if that failed
EXACTNESS_FRACTION = 0.25
# the same for what searches find, at once and apart from that work
EXACTNESS_AT_ONCE_FRACTION = 0.05
STILL_GAINING = 0.05  # of the duration, by as much work again: so much is worth the wait
UNKNOWN = 0.0, 1.0  # what has not been minimised yet


@dataclass
class Shortening:
    """How far a motion has come.

    Attributes:
        given: The motion to begin with.
        shortest: The shortest motion derived from the given one so far, or that one itself.
        work: What that took, in [s].
        curve: The work and the duration in [s] after each gain.
        minimised: The duration in [s] that knots have come to in this round, whose motion may not
            be known yet, and the fraction by which that was still becoming shorter.
        over: Whether nothing more is gained.
        spent: Whether that is because there was no more work.
    """

    given: Trajectory
    shortest: Trajectory
    work: float = 0.0
    curve: list[tuple[float, float]] = field(default_factory=list)
    minimised: tuple[float, float] = UNKNOWN
    over: bool = False
    spent: bool = False

    def duration_at(self, work: float) -> float:
        """Return the duration in [s] that so many seconds of work had led to."""
        return next(duration for after, duration in reversed(self.curve) if after <= work)

    @property
    def last_half_gain(self) -> float:
        """The fraction by which the second half of the work made it shorter."""
        return 1.0 - self.shortest.duration / self.duration_at(0.5 * self.work)

    @property
    def expected_gain(self) -> float:
        """The fraction by which as much work again may be expected to make it shorter, about."""
        duration, still = self.minimised
        promise = max(still, 1.0 - duration / self.shortest.duration)
        return promise if self.over and not self.spent else max(self.last_half_gain, promise)


class Refinement:
    """Shortens a motion, and pauses wherever there has been enough work on it.

    Args:
        incumbent: The best plan; motions that are better are verified on the way.
        given: The motion to begin with.
        remaining: Budget of the work on it.

    Attributes:
        progress: How far it has come.
    """

    def __init__(self, incumbent: Incumbent, given: Trajectory, remaining: Budget) -> None:
        self._incumbent, self._remaining = incumbent, remaining
        self.progress = Shortening(given, given, 0.0, [(0.0, given.duration)])
        self._enough: Callable[[], bool] = never_cancelled
        self._work: Coroutine[None] | None = None

    def go_on(self, until: float, best: Shortening | None = None, after: float = 0.0) -> Shortening:
        """Go on until there has been so much work on the motion, or nothing more is gained.

        Args:
            until: That work, in [s], all that went before included.
            best: Another motion's: this one is given up where it is longer than that one was
                after as much work.
            after: Work in [s] from which they are compared.
        """
        incumbent, made, before = self._incumbent, self.progress, self.progress.shortest

        def enough() -> bool:
            made.work = self._remaining.elapsed
            if best is None or made.work < after:
                return made.work >= until
            return made.work >= until or made.shortest.duration > best.duration_at(made.work)

        if not (made.over or enough()):
            self._enough = enough
            self._work = self._work or Coroutine(self._shorten)
            over = incumbent.tried(self._further)
            if over is None:  # failed or interrupted: its thread ends as soon as it asks its budget
                self._work = None
            made.over = over is not False
        made.work, made.spent = self._remaining.elapsed, self._remaining.over
        if made.shortest is not before and incumbent.beaten_by(made.shortest):
            incumbent.take(made.shortest, "shorten")
        return made

    def finish(self, more: float) -> Shortening:
        """Go on to the end, and make what the motion has come to end in the goal's centre.

        Args:
            more: Work in [s] that there is for it.
        """
        made = self.progress
        if self._remaining.over or (made.over and made.expected_gain >= STILL_GAINING):
            made.over, self._work = False, None  # it had too little work, or none
        self._remaining.time_limit = made.work + more
        self.go_on(math.inf)
        return self.end()

    def end(self) -> Shortening:
        """Make what the motion has come to end in the goal's centre, if it does not."""
        made = self.progress
        if not self._central(made.shortest):
            self._enough = never_cancelled
            made.shortest = self._exact(
                made.shortest, self._budget(self._remaining.clock), EXACTNESS_FRACTION
            )
        return made

    def close(self) -> None:
        """Shorten it no further."""
        if self._work is not None:
            self._work.close()

    def offered_exact(self) -> Trajectory:
        """Offer a motion into the goal's centre to whoever stops soon, apart from counted work.

        Returns:
            That motion, or the given one.
        """
        given = self.progress.given
        if self._central(given):
            return given
        with counted_work(apart=True) as own:
            budget = self._budget(lambda: own.seconds)
            return self._exact(given, budget, EXACTNESS_AT_ONCE_FRACTION)

    def _central(self, motion: Trajectory) -> bool:
        return self._incumbent.problem.goal_distance(motion.x[-1]) <= CENTRE_TOLERANCE

    def _budget(self, clock: Callable[[], float]) -> Budget:
        return Budget(self._remaining.time_limit, clock=clock, cancelled=self._incumbent.cancelled)

    def _further(self) -> bool:
        """Go on with the work until it pauses; say whether nothing more is gained."""
        assert self._work is not None
        self._work.resume()
        over = self._work.wait()
        if over:
            self._work.result  # noqa: B018 - raises what the work has raised
        return over

    def _pauses(self) -> bool:
        """Pause where there has been enough work; say whether the rest is not wanted any more."""
        return self._work is not None and self._enough() and self._work.suspend()

    def _shorten(self) -> None:
        """Make the motion shorter and shorter, as long as the verifier agrees."""
        incumbent, made, refusals = self._incumbent, self.progress, 0
        for motion in self._shorter_and_shorter():
            # of the duration, for a verification while more is to come
            if not incumbent.beaten_by(motion, 0.03) or incumbent.take(motion, "shorten"):
                made.shortest, made.work = motion, self._remaining.elapsed
                made.curve.append((made.work, motion.duration))
            else:
                refusals += 1
            # shorter motions that the verifier refuses before others are tried
            if refusals >= 2 or self._pauses():
                return

    def _shorter_and_shorter(self) -> Iterator[Trajectory]:
        """Yield shorter motions; what is long and verified first loses its detours."""
        problem, made = self._incumbent.problem, self.progress
        long = trajopt.is_long(problem, made.shortest)
        if not (long and self._incumbent.best.status == "solved"):
            fraction = EXACTNESS_FRACTION if long else 1.0
            made.shortest = self._exact(made.shortest, self._remaining, fraction)
        while not self._remaining.over:
            before = made.shortest.duration
            spent = self._spent(self._remaining)
            made.minimised = UNKNOWN
            yield from trajopt.shortened(problem, made.shortest, spent, self._minimised)
            # fraction of the duration that justifies another round
            if not made.shortest.duration < (1 - 1e-3) * before:
                return

    def _minimised(self, duration: float, still: float) -> None:
        self.progress.minimised = duration, still

    def _spent(self, budget: Budget, fraction: float = 1.0) -> Callable[[], float]:
        """Return how much of a budget is spent, as it does itself, with pauses on the way."""
        spent = budget.fraction(fraction)
        return lambda: math.inf if self._pauses() else spent()

    def _exact(self, motion: Trajectory, budget: Budget, fraction: float = 1.0) -> Trajectory:
        """Return a motion into the goal's centre, or the same one."""
        spent = self._spent(budget, fraction)
        exact = self._incumbent.tried(
            lambda: trajopt.make_exact(self._incumbent.problem, motion, lambda: spent() >= 1.0)
        )
        if exact is None:
            return motion
        self._incumbent.take(exact, "repair")
        return exact


class RefinedWay:
    """A motion that is shortened beside others.

    Args:
        given: The motion to begin with.
        remaining: Budget of the work on all of them.
        share: Of what is left of that, for this one at most.
        alone: Whether there are no others.

    Attributes:
        given: As above.
        fork: Shortens it.
        progress: How far it has come, as this process knows.
    """

    def __init__(
        self,
        incumbent: Incumbent,
        given: Start,
        remaining: Budget,
        share: float = 1.0,
        *,
        alone: bool = False,
    ) -> None:
        own = incumbent.apart()
        most = share * remaining.unspent  # [s]
        budget = Budget(most, clock=lambda: own.clock.seconds, cancelled=remaining.cancelled)
        self.given = given
        self._refinement = Refinement(own, given.motion, budget)
        self.progress = self._refinement.progress
        self.fork = own.forked(self._do, alone=alone)

    @property
    def duration(self) -> float:
        """Of the shortest motion so far, in [s]."""
        return self.progress.shortest.duration

    def end(self) -> None:
        """Shorten it no further."""
        self.fork.end()
        self._refinement.close()

    def _do(self, method: Callable[..., Shortening], *arguments: Any) -> Shortening:
        return method(self._refinement, *arguments)
