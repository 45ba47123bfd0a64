"""Search results: outcome, inputs and statistics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from kinolab.numerics.arrays import Array
from kinolab.search.budget import Budget
from kinolab.search.graph import SearchGraph


class Outcome(Enum):
    """How a search ended; the value is the sentence the user reads."""

    SOLVED = "Found a trajectory into the goal region."
    APPROXIMATE = "Did not reach the goal; the nearest approach is kept."
    NOT_FOUND = "Found no motion that comes nearer to the goal than the start."
    LOCAL_MINIMUM = (
        "Stuck in a local minimum of the potential; the nearest approach is kept. "
        "Raise [planner] random_walk_escapes or set navigation = true."
    )
    INTERRUPTED = "Interrupted; the nearest approach is kept."


@dataclass(frozen=True, repr=False)
class SearchResult:
    """Result of a search.

    Attributes:
        outcome: How it ended.
        t: Times of the knots in [s], shape (N+1,); a single 0 if nothing was found.
        u: Inputs per interval, shape (N, nu).
        iterations: Number of attempted extensions.
        statistics: Counters to report, by name.
        rejections: Fractions of all rejected motions, by cause and source.
        graph: Search graph, None if the planner keeps none.
        warnings: What is wrong with the search, in sentences.
    """

    outcome: Outcome
    t: Array
    u: Array
    iterations: int
    statistics: Mapping[str, float] = field(default_factory=dict)
    rejections: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    graph: SearchGraph | None = None
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Say in a line what came of it."""
        steps = f"{len(self.u)} step{'s' if len(self.u) != 1 else ''}"
        return f"<SearchResult {self.outcome.name}: {steps}, {self.iterations} iterations>"


def unsolved(budget: Budget, steps: int) -> Outcome:
    """Return how a search ended that did not reach the goal.

    Args:
        budget: What ended it.
        steps: Of its nearest approach; 0 where nothing comes nearer than the start.
    """
    if budget.interrupted:
        return Outcome.INTERRUPTED
    return Outcome.APPROXIMATE if steps else Outcome.NOT_FOUND
