"""How much room the machine has at a state, and to what."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import Problem
from kinolab.world import CollisionChecker

Array: TypeAlias = NDArray[np.float64]

TIGHT = 0.05  # [m] of room that is worth a sentence
JUST = 1e-5  # [m] beyond the room there is, where something touches


@dataclass(frozen=True)
class Room:
    """The room at a state.

    Attributes:
        clearance: How far every point may move, in [m]; infinite where nothing is around.
        beside: The pairs of body and obstacle that touch first.
    """

    clearance: float
    beside: tuple[str, ...]

    def __str__(self) -> str:
        return f"{100 * self.clearance:.2g} cm of room ({', '.join(self.beside)})"


def room_at(problem: Problem, x: Array, checker: CollisionChecker) -> Room:
    """Return the room at a state; 0 where it collides."""
    place = problem.placement(x)
    clearance = checker.clearance(*place)
    if math.isinf(clearance):
        return Room(clearance, ())
    reaching = checker.inflated(clearance + JUST, ground=problem.world.ground)
    pairs = (f"{contact.body} – {contact.obstacle}" for contact in reaching.contacts(*place))
    return Room(clearance, tuple(dict.fromkeys(pairs)))


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
