"""A motion that improvement makes exact and shorter and shorter, for as long as its work pays.

Improvement keeps the way on which a motion goes round obstacles, so that several motions, which
may go on different ways, are each improved for a while.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from kinolab import trajopt
from kinolab.concurrency.cancel import never_cancelled
from kinolab.numerics.work import counted_work
from kinolab.search import Budget
from kinolab.solve.incumbent import Incumbent
from kinolab.solve.plan import CENTRE_TOLERANCE
from kinolab.trajectory import Trajectory

# of the improvement's work, to make a motion exact before it is shortened
EXACTNESS_FRACTION = 0.25
# the same for what searches find, at once and apart from that work
EXACTNESS_AT_ONCE_FRACTION = 0.05
MIN_GAIN = 1e-3  # fraction of the duration that justifies another round
VERIFIED_GAIN = 0.03  # the same for a verification while more is to come
MAX_REFUSALS = 2  # shorter motions that the verifier refuses before others are tried


@dataclass
class Refinement:
    """A motion, and what has been made of it.

    Attributes:
        incumbent: The best plan; motions that are better are verified on the way.
        given: The motion to begin with.
        remaining: Budget of the improvement's work.
        shortest: The shortest motion derived from the given one so far, or that one itself.
        work: What that took, in [s].
        curve: The work and the duration in [s] after each gain.
        over: Whether nothing more is gained.
    """

    incumbent: Incumbent
    given: Trajectory
    remaining: Budget
    shortest: Trajectory = field(init=False)
    work: float = 0.0
    curve: list[tuple[float, float]] = field(default_factory=list)
    over: bool = False
    _refusals: int = 0

    def __post_init__(self) -> None:
        self.shortest, self._motions = self.given, self._shorter_and_shorter()
        self.curve.append((0.0, self.given.duration))

    def go_on(self, enough: Callable[[], bool] = never_cancelled) -> Trajectory:
        """Go on until that is enough, or nothing more is gained; return the shortest motion."""
        incumbent, before = self.incumbent, self.shortest
        while not (self.over or enough()):
            with counted_work() as work:
                motion = incumbent.tried(lambda: next(self._motions, None))
            self.work += work.seconds
            if motion is None:
                self.over = True
            elif not incumbent.beaten_by(motion, VERIFIED_GAIN) or incumbent.take(
                motion, "shorten"
            ):
                self.shortest = motion
                self.curve.append((self.work, motion.duration))
            else:
                self._refusals += 1
                self.over = self._refusals >= MAX_REFUSALS
        if self.shortest is not before and incumbent.beaten_by(self.shortest):
            incumbent.take(self.shortest, "shorten")
        return self.shortest

    def race(self, other: Refinement, work: float) -> None:
        """Go on, after some work as long as it is no longer than another way's motion then was.

        Args:
            other: That way.
            work: After which they are compared, in [s].
        """

        def behind() -> bool:
            return self.work >= work and self.shortest.duration > other.duration_at(self.work)

        self.go_on(behind)

    def duration_at(self, work: float) -> float:
        """Return the duration in [s] that so many seconds of work had led to."""
        return next(duration for after, duration in reversed(self.curve) if after <= work)

    def end(self) -> None:
        """Make what it has come to end in the goal's centre, if it does not."""
        if not self._central(self.shortest):
            self.shortest = self._exact(self.shortest, self._budget(self.remaining.clock))

    def offer_exact(self) -> None:
        """Offer a motion into the goal's centre to whoever stops soon, apart from counted work."""
        if self._central(self.given):
            return
        with counted_work(apart=True) as own:
            self._exact(self.given, self._budget(lambda: own.seconds), EXACTNESS_AT_ONCE_FRACTION)

    def _central(self, motion: Trajectory) -> bool:
        return self.incumbent.problem.goal_distance(motion.x[-1]) <= CENTRE_TOLERANCE

    def _budget(self, clock: Callable[[], float]) -> Budget:
        return Budget(self.remaining.time_limit, clock=clock, cancelled=self.incumbent.cancelled)

    def _shorter_and_shorter(self) -> Iterator[Trajectory]:
        """Yield shorter motions; what is long and verified first loses its detours."""
        problem, given = self.incumbent.problem, self.given
        long = trajopt.is_long(problem, given)
        if not (long and self.incumbent.best.status == "solved"):
            self.shortest = self._exact(given, self.remaining, EXACTNESS_FRACTION if long else 1.0)
        while not self.remaining.over:
            before = self.shortest.duration
            yield from trajopt.shortened(problem, self.shortest, self.remaining.fraction())
            if not self.shortest.duration < (1 - MIN_GAIN) * before:
                return

    def _exact(self, motion: Trajectory, budget: Budget, fraction: float = 1.0) -> Trajectory:
        """Return a motion into the goal's centre, or the same one."""
        spent = budget.fraction(fraction)
        exact = self.incumbent.tried(
            lambda: trajopt.make_exact(self.incumbent.problem, motion, lambda: spent() >= 1.0)
        )
        if exact is None:
            return motion
        self.incumbent.take(exact, "repair")
        return exact
