"""The clearance of the machine at a state, and to what."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.verification.clearance_margin import StateClearance, state_clearance
from kinolab.world import CollisionChecker

TIGHT_CLEARANCE = 0.05  # [m] that are worth a sentence


def largest_clearance(
    problem: PlanningTask, states: Sequence[Array], checker: CollisionChecker
) -> StateClearance | None:
    """Return the largest clearance of states (nx,); None where there are none."""
    if not states:
        return None
    clearances = [checker.clearance(*problem.placement(x)) for x in states]
    return state_clearance(problem, states[int(np.argmax(clearances))], checker)


def clearance_sentences(start: StateClearance, goal: StateClearance | None) -> Iterator[str]:
    """Say where clearance is small; what is the same everywhere is how the machine is built."""
    if start == goal:
        return
    for where, clearance in (("at the start", start), ("in the goal, at best", goal)):
        if clearance is not None and clearance.clearance < TIGHT_CLEARANCE:
            yield f"There is little clearance {where}: {clearance}."
