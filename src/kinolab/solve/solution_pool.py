"""Solution pool: the best plan over all seeds, and the outcome of each."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from kinolab.solve.plan import Attempt, Improvement, PlanResult


@dataclass
class SolutionPool:
    """Collects plans and keeps the best one.

    Attributes:
        jobs: Number of parallel searches.
        improved: Called with each verified plan that is better than all before.
        best: None until a search has ended.
        attempts: Outcome of each seed.
    """

    jobs: int
    improved: Callable[[PlanResult], None] | None = None
    best: PlanResult | None = None
    attempts: list[Attempt] = field(default_factory=list)
    _improvements: set[Improvement] = field(default_factory=set)

    @property
    def all(self) -> tuple[Attempt, ...]:
        """All attempts, in the order of their seeds."""
        return tuple(sorted(self.attempts, key=lambda attempt: attempt.seed))

    def add(self, found: PlanResult, after: float) -> None:
        """Add a finished search, ``after`` seconds from the beginning of the first one."""
        self.attempts.append(ended(found, after))
        self.compare(found)
        if self.best is not None and found.seed == self.best.seed:
            self.best = found  # now complete

    def compare(self, found: PlanResult) -> None:
        """Keep a plan if it is the best so far, and report it if it is verified."""
        self._improvements.update(found.improvements)
        if self.best is None or found.rank < self.best.rank:
            self.best = found
            if found.status == "solved" and self.improved:
                self.improved(self._with_all(found))

    def plan(self, *, interrupted: bool) -> PlanResult | None:
        """Return the best plan with all attempts; None if no search has ended."""
        if self.best is None:
            return None
        return replace(self._with_all(self.best), interrupted=interrupted)

    def _with_all(self, found: PlanResult) -> PlanResult:
        improvements = tuple(sorted(self._improvements))
        return replace(found, jobs=self.jobs, attempts=self.all, improvements=improvements)


def ended(found: PlanResult, after: float) -> Attempt:
    """Return the attempt of a completed search."""
    distance = found.goal_distance if math.isfinite(found.goal_distance) else None
    return Attempt(
        found.seed,
        found.status,
        found.iterations,
        found.cost,
        distance,
        after,
        refused=sum(found.refused.values()),
    )
