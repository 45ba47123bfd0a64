"""How much room the machine has at a state, and to what."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import Problem
from kinolab.verification.clearance_margin import Room, room_at
from kinolab.world import CollisionChecker

Array: TypeAlias = NDArray[np.float64]

TIGHT = 0.05  # [m] of room that is worth a sentence


def most_room(problem: Problem, states: Sequence[Array], checker: CollisionChecker) -> Room | None:
    """Return the room at the state that has most of it; None where there are no states."""
    if not states:
        return None
    rooms = [checker.clearance(*problem.placement(x)) for x in states]
    return room_at(problem, states[int(np.argmax(rooms))], checker)


def room_sentences(start: Room, goal: Room | None) -> Iterator[str]:
    """Say where there is little room; what is the same everywhere is how the machine is built."""
    if start == goal:
        return
    for where, room in (("at the start", start), ("in the goal, at best", goal)):
        if room is not None and room.clearance < TIGHT:
            yield f"There is little room {where}: {room}."
