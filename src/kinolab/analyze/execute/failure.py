"""Why executions failed: what touched, left, missed or broke down, when, and how many did alike."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

Outcome: TypeAlias = Literal["reached", "missed", "collided", "strayed", "lost"]

# What a run did, before its cause is named.
PHRASES: dict[Outcome, str] = {
    "missed": "missed the goal",
    "collided": "collided",
    "strayed": "strayed",
    "lost": "could not be followed",
}


@dataclass(frozen=True)
class Failure:
    """Why one run failed.

    Attributes:
        outcome: How it ended.
        cause: What failed, in the same words for all runs that fail alike, such as
            ``left wheel – ground``.
        detail: The same with numbers.
        time: When, in [s] from the start.
        step: After how many steps of the plan; 0 at the start.
        bodies: Names of what touched or left, if any.
        slip: Since when it was in another mode than the plan, in words, of machines with modes.
    """

    outcome: Outcome
    cause: str
    detail: str
    time: float
    step: int
    bodies: tuple[str, ...] = ()
    slip: str = ""

    @property
    def at_start(self) -> bool:
        """Whether it was so before anything moved."""
        return self.step == 0

    @property
    def kind(self) -> tuple[Outcome, bool, str]:
        """The same for all runs that fail alike."""
        return self.outcome, self.at_start, self.cause

    @property
    def phrase(self) -> str:
        """What happened, such as ``collided at the start: left wheel – ground``."""
        where = {"missed": "", "lost": " on the way"}.get(
            self.outcome, " at the start" if self.at_start else " on the way"
        )
        return f"{PHRASES[self.outcome]}{where}: {self.cause}"


@dataclass(frozen=True)
class FailureGroup:
    """Runs that failed alike.

    Attributes:
        count: How many.
        run: Number of the first of them, from 0.
        first: Why that one failed.
    """

    count: int
    run: int
    first: Failure

    def __str__(self) -> str:
        first = self.first
        when = "" if first.at_start else f" at {first.time:.3g} s, in step {first.step}"
        detail = "; ".join(filter(None, (first.detail, first.slip)))
        return f"{self.count} {first.phrase} (run {self.run + 1}{when}: {detail})"


class FailureCount:
    """Counts failures as they come."""

    def __init__(self) -> None:
        self._groups: dict[object, FailureGroup] = {}

    def add(self, run: int, failure: Failure) -> None:
        """Count a failure of a run, numbered from 0."""
        known = self._groups.get(failure.kind, FailureGroup(0, run, failure))
        self._groups[failure.kind] = replace(known, count=known.count + 1)

    @property
    def groups(self) -> tuple[FailureGroup, ...]:
        """All of them, the most frequent first."""
        return tuple(sorted(self._groups.values(), key=lambda group: (-group.count, group.run)))
