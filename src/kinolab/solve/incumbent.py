"""The best verified plan so far, to which improvement offers what it finds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeVar

from kinolab.errors import KinolabError
from kinolab.numerics.work import charge
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.solve.attempt import MIN_SEARCH_WORK, judging
from kinolab.solve.plan import Improvement, PlanResult
from kinolab.trajectory import Trajectory
from kinolab.verification import verify

T = TypeVar("T")

SEARCHED_ALONE = "Found a trajectory into the goal region, which the search alone had missed."
VERIFICATION_SECONDS = 2e-4  # [s] for each knot, as ``charge`` counts it


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
