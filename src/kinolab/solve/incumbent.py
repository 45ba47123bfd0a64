"""The best plan of one search, while it is being improved."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TypeVar

from kinolab.errors import KinolabError
from kinolab.problem import Problem
from kinolab.search import Budget
from kinolab.solve.attempt import judging
from kinolab.solve.plan import Improvement, Plan
from kinolab.solve.solution_pool import rank
from kinolab.trajectory import Trajectory
from kinolab.verification import verify

T = TypeVar("T")

SEARCHED_ALONE = "Found a trajectory into the goal region, which the search alone had missed."


@dataclass
class Incumbent:
    """Keeps the better one of two motions if it passes the verifier.

    Attributes:
        problem: That they solve.
        best: The best plan so far, as its search gave it but for the motion.
        budget: By which the user may interrupt.
        time: Tells the seconds since the first search began.
        on_improved: Called with each verified plan that is better than those before.
        improvements: All verified motions.
    """

    problem: Problem
    best: Plan
    budget: Budget
    time: Callable[[], float]
    on_improved: Callable[[Plan], None] | None = None
    improvements: list[Improvement] = field(default_factory=list)

    @property
    def stopped(self) -> bool:
        """Whether nobody waits any more."""
        return self.budget.interrupted or self.budget.abandoned

    def begin(self) -> None:
        """Note the plan that the search gave."""
        if self.best.status == "solved" and self.best.trajectory is not None:
            self._note(self.best.trajectory, self.best.goal_distance, "search")
            self._tell()

    def tried(self, work: Callable[[], T]) -> T | None:
        """Return what some work gives, None where it fails or the user does not wait for it."""
        if self.stopped:
            return None
        try:
            return self.budget.breaking(work, patience=1)
        except (KinolabError, ArithmeticError):
            return None  # there is a plan already, and no need for another one

    def take(self, trajectory: Trajectory, by: str) -> bool:
        """Verify a motion that is the first exact one or better; return whether it is kept."""
        if not self._of_interest(trajectory):
            return False
        certificate = None
        with judging:  # it may be a while until it is this thread's turn
            if not self.stopped:
                certificate = self.budget.breaking(lambda: verify(self.problem, trajectory))
        if certificate is None or not certificate.passed:
            return False
        distance = self.problem.goal_distance(trajectory.x[-1])
        self._note(trajectory, distance, by)
        found = replace(
            self.best,
            status="solved",
            trajectory=trajectory,
            certificate=certificate,
            goal_distance=distance,
            message=self._message,
        )
        better = rank(found) < rank(self.best)
        if better:
            self.best = found
            self._tell()
        return better

    def plan(
        self,
        timings: Mapping[str, float] | None = None,
        statistics: Mapping[str, float] | None = None,
    ) -> Plan:
        """Return the best plan with all that is known of it."""
        return replace(
            self.best,
            timings={**self.best.timings, **(timings or {})},
            statistics={**self.best.statistics, **(statistics or {})},
            interrupted=self.best.interrupted or self.budget.interrupted,
            improvements=tuple(self.improvements),
        )

    def _of_interest(self, trajectory: Trajectory) -> bool:
        """Say whether a motion would be the first exact one, or the best, if it were verified."""
        distance = self.problem.goal_distance(trajectory.x[-1])
        found = replace(self.best, trajectory=trajectory, goal_distance=distance)
        return self.best.status != "solved" or rank(found) < rank(self.best)

    @property
    def _message(self) -> str:
        return self.best.message if self.best.status == "solved" else SEARCHED_ALONE

    def _note(self, trajectory: Trajectory, distance: float, by: str) -> None:
        self.improvements.append(
            Improvement(self.time(), trajectory.duration, distance, by, self.best.seed)
        )

    def _tell(self) -> None:
        if self.on_improved:
            self.on_improved(replace(self.best, improvements=tuple(self.improvements)))
