"""The best verified plan so far, to which improvement offers what it finds."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic, TypeVar

from kinolab.concurrency.forks import Fork, Telling, answers
from kinolab.errors import KinolabError
from kinolab.numerics.compiling import compilation, count_elsewhere
from kinolab.numerics.work import WorkClock, charge, counted_work
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.simulation.reference import price
from kinolab.solve.attempt import MIN_SEARCH_WORK, judging
from kinolab.solve.plan import Improvement, PlanResult
from kinolab.trajectory import Trajectory
from kinolab.verification import verify

T = TypeVar("T")

SEARCHED_ALONE = "Found a trajectory into the goal region, which the search alone had missed."
AT_ONCE = 2  # lines of work, in turn on one processor: their number must not change what is done


@dataclass(frozen=True)
class Done(Generic[T]):
    """What came of some work, what it took, and what a fork took to compile for it, in [s]."""

    result: T
    work: float
    compiling: float


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
        clock: Counts the work of what is done apart from others.
    """

    problem: PlanningTask
    best: PlanResult
    budget: Budget
    time: Callable[[], float]
    on_improved: Callable[[PlanResult], None] | None = None
    improvements: list[Improvement] = field(default_factory=list)
    clock: WorkClock = field(default_factory=WorkClock)

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

    def apart(self) -> Incumbent:
        """Return one with the same plan and a clock of its own, for work beside that of others."""
        return replace(self, improvements=[], clock=WorkClock(), on_improved=None)

    def forked(self, work: Callable[..., T], *, alone: bool = False) -> Fork[Done[T]]:
        """Return a fork that does some work apart from others, for ``joined``.

        Args:
            work: Uses this incumbent, and no other.
            alone: Whether no other work is done at the same time.
        """

        here = os.getpid()

        def answer(arguments: Sequence[Any], tell: Telling) -> Done[T]:
            self.on_improved, before = tell, self.clock.seconds
            with counted_work(apart=True, clock=self.clock), compilation() as compiling:
                result = work(*arguments)
            elsewhere = compiling.seconds if os.getpid() != here else 0.0  # nobody counts it there
            return Done(result, self.clock.seconds - before, elsewhere)

        return Fork(answer, alone=alone)

    def joined(self, forks: Sequence[Fork[Done[T]]]) -> list[T] | None:
        """Wait for what forks were asked; charge its work, and keep what is better than the best.

        What ``AT_ONCE`` processors need for it is charged, whether there are as many or not.

        Returns:
            Their results; None after an interrupt by the user.
        """
        told: list[tuple[int, PlanResult]] = [(-1, self.best)]

        def tell(k: int, plan: PlanResult) -> None:
            told.append((k, plan))
            if plan.rank < self.best.rank:
                self.best = plan
                self.improvements.append(plan.improvements[-1])
                if self.on_improved:
                    self.on_improved(replace(plan, improvements=tuple(self.improvements)))

        found = answers(forks, tell, self.cancelled)
        # Of motions that are equally good the first fork's, whoever was the first to tell.
        self.best = min(told, key=lambda one: (one[1].rank, one[0]))[1]
        count_elsewhere(max((done.compiling for done in found or ()), default=0.0))
        work = [done.work for done in found or ()]
        charge(max(sum(work) / AT_ONCE, *work, 0.0))
        return None if found is None else [done.result for done in found]

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
            charge(2e-4 * len(trajectory.t))  # [s] for each knot, as ``charge`` counts it
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
            price=price(self.problem, trajectory),
            goal_distance=self.problem.goal_distance(trajectory.x[-1]),
            message=self.best.message if self.best.status == "solved" else SEARCHED_ALONE,
        )

    def _keep(self, found: PlanResult, by: str) -> None:
        made = Improvement(
            self.time(), found.duration or 0.0, found.goal_distance, by, found.seed, found.price
        )
        self.improvements.append(made)
        self.best = found
        if self.on_improved:
            self.on_improved(replace(found, improvements=tuple(self.improvements)))
