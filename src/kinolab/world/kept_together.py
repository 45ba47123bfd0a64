"""What is made of several obstacles together, made once for each company of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Generic, TypeVar
from weakref import WeakKeyDictionary, ref

from kinolab.world.obstacle import Obstacle

T = TypeVar("T")


class KeptTogether(Generic[T]):
    """Keeps what was made of obstacles as long as the first of them is, for its last company.

    Obstacles do not change, so that every search of a problem finds it: nobody may write to it.

    Args:
        make: Makes it of obstacles.
    """

    def __init__(self, make: Callable[[Sequence[Obstacle]], T]) -> None:
        self._make = make
        self._known: WeakKeyDictionary[Obstacle, tuple[list[ref[Obstacle]], T]] = (
            WeakKeyDictionary()
        )

    @cached_property
    def _of_none(self) -> T:
        return self._make(())

    def __call__(self, obstacles: Sequence[Obstacle]) -> T:
        """Return what is made of obstacles, in their order."""
        if not obstacles:
            return self._of_none
        together = [ref(obstacle) for obstacle in obstacles]
        known = self._known.get(obstacles[0])
        if known is None or known[0] != together:
            known = self._known[obstacles[0]] = together, self._make(obstacles)
        return known[1]
