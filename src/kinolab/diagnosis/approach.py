"""How near a state comes to the goal, entry by entry."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import Problem

Array: TypeAlias = NDArray[np.float64]

SHOWN = 3  # entries that a sentence names


@dataclass(frozen=True)
class GoalEntry:
    """One thing that the goal asks for, and what became of it.

    Attributes:
        name: Of a coordinate or rate, or what is measured, such as ``distance of hook``.
        value: What was reached, in its SI unit.
        target: What was wanted; 0 for distances and angles from a target.
        error: How far the value is from the target, on the circle for angles that wrap.
        tolerance: Largest error inside the goal.
    """

    name: str
    value: float
    target: float
    error: float
    tolerance: float

    @property
    def reached(self) -> bool:
        """Whether the error is within the tolerance."""
        return self.error <= self.tolerance

    def __str__(self) -> str:
        wanted = f"{self.target:.4g} ± {self.tolerance:.3g}"
        return f"{self.name} = {self.value:.4g} (wanted {wanted})"


def goal_entries(problem: Problem, x: Array) -> tuple[GoalEntry, ...]:
    """Return every entry of the goal at a state, those missed by most tolerances first."""
    entries = _entries(problem, x)
    return tuple(sorted(entries, key=lambda entry: -entry.error / entry.tolerance))


def _entries(problem: Problem, x: Array) -> Iterator[GoalEntry]:
    goal, model, bodies = problem.goal, problem.model, problem.bodies
    rows = zip(goal.indices, goal.targets, goal.deviations(x), goal.tolerances, strict=True)
    for i, target, deviation, tolerance in rows:
        value = float(x[i])
        if problem.circular[i]:
            value = math.remainder(value, 2 * math.pi)
        error = abs(float(deviation))
        yield GoalEntry(model.state_names[i], value, float(target), error, float(tolerance))
    for attitude in goal.attitudes:
        turn = attitude.turn(x)
        yield GoalEntry(f"turn of {attitude.name}", turn, 0.0, turn, attitude.tolerance)
    frames = problem.frames(x)
    for point in goal.points:
        away = point.distance(frames)
        yield GoalEntry(f"distance of {bodies[point.body].name}", away, 0.0, away, point.tolerance)
    for target in goal.directions:
        turn = target.angle(frames)
        yield GoalEntry(f"angle of {bodies[target.body].name}", turn, 0.0, turn, target.tolerance)


def approach_sentences(entries: Sequence[GoalEntry], *, moved: bool) -> Iterator[str]:
    """Say what the nearest approach misses and what it reaches.

    Args:
        entries: Of the goal, those missed by most tolerances first.
        moved: Whether there was an approach at all; otherwise they are the start's.
    """
    missed = [entry for entry in entries if not entry.reached]
    reached = [entry.name for entry in entries if entry.reached]
    if not missed:
        return
    more = f" and {len(missed) - SHOWN} more" if len(missed) > SHOWN else ""
    kept = f"; it reaches {', '.join(reached)}" if reached else ""
    approach = "The nearest approach" if moved else "Nothing came nearer than the start, which"
    yield f"{approach} misses {', '.join(map(str, missed[:SHOWN]))}{more}{kept}."


def unmet_sentences(problem: Problem, nearest: Array) -> Iterator[str]:
    """Say that no state meets the goal, and what the one that comes nearest misses."""
    missed = [entry for entry in goal_entries(problem, nearest) if not entry.reached]
    if missed:
        shown = ", ".join(map(str, missed[:SHOWN]))
        yield f"The machine has no configuration in the goal: the nearest one misses {shown}."
