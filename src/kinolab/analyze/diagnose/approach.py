"""Sentences about a state's goal errors, entry by entry."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.goal_entries import GoalEntry, goal_entries

MAX_NAMED = 3  # entries that a sentence names


def approach_sentences(entries: Sequence[GoalEntry], *, moved: bool) -> Iterator[str]:
    """Say which goal entries the nearest approach misses and which it reaches.

    Args:
        entries: Goal entries, by descending error in tolerances.
        moved: Whether the search has a nearest approach; otherwise they are the start's.
    """
    missed = [entry for entry in entries if not entry.reached]
    reached = [entry.name for entry in entries if entry.reached]
    if not missed:
        return
    more = f" and {len(missed) - MAX_NAMED} more" if len(missed) > MAX_NAMED else ""
    kept = f"; it reaches {', '.join(reached)}" if reached else ""
    approach = "The nearest approach" if moved else "Nothing came nearer than the start, which"
    yield f"{approach} misses {', '.join(map(str, missed[:MAX_NAMED]))}{more}{kept}."


def unmet_sentences(problem: PlanningTask, nearest: Array) -> Iterator[str]:
    """Say that no state meets the goal, and what the nearest one, shape (nx,), misses."""
    missed = [entry for entry in goal_entries(problem, nearest) if not entry.reached]
    if missed:
        shown = ", ".join(map(str, missed[:MAX_NAMED]))
        yield f"The machine has no configuration in the goal: the nearest one misses {shown}."
