"""Clearances of states and their errors to the goal, in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinolab.errors import a_few
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.goal_entries import GoalEntry, goal_entries
from kinolab.verification.between_samples.clearance_margin import StateClearance, state_clearance
from kinolab.world import CollisionChecker


def largest_clearance(
    problem: PlanningTask, states: Sequence[Array], checker: CollisionChecker
) -> StateClearance | None:
    """Return the largest clearance of states (nx,); None if there are none."""
    if not states:
        return None
    clearances = [checker.clearance(*problem.placement(x)) for x in states]
    return state_clearance(problem, states[int(np.argmax(clearances))], checker)


def clearance_sentences(start: StateClearance, goal: StateClearance | None) -> Iterator[str]:
    """Say where clearance is small; equal values at both ends are due to the machine itself."""
    if start == goal:
        return
    for where, clearance in (("at the start", start), ("in the goal, at best", goal)):
        # 0.05 [m] below which clearance is reported
        if clearance is not None and clearance.clearance < 0.05:
            yield f"There is little clearance {where}: {clearance}."


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
    kept = f"; it reaches {', '.join(reached)}" if reached else ""
    approach = "The nearest approach" if moved else "Nothing came nearer than the start, which"
    yield f"{approach} misses {a_few(missed, 3)}{kept}."


def unmet_sentences(problem: PlanningTask, nearest: Array) -> Iterator[str]:
    """Say that no state meets the goal, and what the nearest one, shape (nx,), misses."""
    missed = [entry for entry in goal_entries(problem, nearest) if not entry.reached]
    if missed:
        shown = ", ".join(map(str, missed[:3]))
        yield f"The machine has no configuration in the goal: the nearest one misses {shown}."
