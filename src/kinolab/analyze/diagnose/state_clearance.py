"""Largest clearance of several states, and sentences about small clearances."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.verification.clearance_margin import StateClearance, state_clearance
from kinolab.world import CollisionChecker

TIGHT_CLEARANCE = 0.05  # [m] below which clearance is reported


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
        if clearance is not None and clearance.clearance < TIGHT_CLEARANCE:
            yield f"There is little clearance {where}: {clearance}."
