"""What is made of several obstacles together, made once for each company of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial, wraps
from typing import TypeVar
from weakref import WeakKeyDictionary, ref

from kinolab.world.obstacles.obstacle import Obstacle

T = TypeVar("T")


def kept_together(make: Callable[[Sequence[Obstacle]], T]) -> Callable[[Sequence[Obstacle]], T]:
    """Keep what is made of obstacles as long as the first of them is, for its last company.

    Obstacles do not change, so that every search of a problem finds it: nobody may write to it.

    Args:
        make: Makes it of obstacles, in their order.
    """
    of_none = cache(partial(make, ()))
    known = WeakKeyDictionary[Obstacle, tuple[list[ref[Obstacle]], T]]()

    @wraps(make)
    def kept(obstacles: Sequence[Obstacle]) -> T:
        if not obstacles:
            return of_none()
        together = [ref(obstacle) for obstacle in obstacles]
        found = known.get(obstacles[0])
        if found is None or found[0] != together:
            found = known[obstacles[0]] = together, make(obstacles)
        return found[1]

    return kept
