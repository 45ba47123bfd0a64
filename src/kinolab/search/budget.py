"""How much an optimisation may use up: time on the clock, or a number of subproblems."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from itertools import count
from typing import TypeAlias, final

IsSpent: TypeAlias = Callable[[], float]


class AbstractBudget(ABC):
    """What is left, and parts of it to give away.

    Args:
        until: When it ends, whatever is left, by the clock.
        clock: Tells the time in [s].
        stopped: Whether to use up nothing more.

    Attributes:
        until: As given; it may be brought forward.
    """

    def __init__(
        self, until: float, clock: Callable[[], float], stopped: Callable[[], bool]
    ) -> None:
        self.until = until
        self._clock, self._stopped = clock, stopped

    @property
    @abstractmethod
    def left(self) -> float:
        """How much is left; 0 or less where nothing is."""

    @property
    def over(self) -> bool:
        """Whether nothing more may be used up."""
        return self._stopped() or self._clock() >= self.until or self.left <= 0

    def fraction(self, fraction: float = 1.0) -> IsSpent:
        """Return what tells how much is spent of a share of what is left: 1 where all of it is.

        It is asked before each subproblem.
        """
        before = self.left
        whole = fraction * before

        def spent() -> float:
            if self.over or whole <= 0:
                return math.inf
            self._ask()
            return (before - self.left) / whole

        return spent

    @abstractmethod
    def _ask(self) -> None:
        """Count a question."""


@final
class TimeBudget(AbstractBudget):
    """Time on the clock."""

    def __init__(
        self,
        until: float,
        clock: Callable[[], float],
        stopped: Callable[[], bool] = lambda: False,
    ) -> None:
        super().__init__(until, clock, stopped)

    @property
    def left(self) -> float:
        """How many seconds are left."""
        return self.until - self._clock()

    def _ask(self) -> None:
        """Time goes by itself."""


@final
class SubproblemBudget(AbstractBudget):
    """A number of subproblems, which gives the same result on every computer."""

    def __init__(
        self,
        most: int,
        until: float = math.inf,
        clock: Callable[[], float] = time.monotonic,
        stopped: Callable[[], bool] = lambda: False,
    ) -> None:
        super().__init__(until, clock, stopped)
        self._left = most

    @property
    def left(self) -> float:
        """How many subproblems are left."""
        return float(self._left)

    def _ask(self) -> None:
        self._left -= 1


def throttled(cancelled: Callable[[], bool], times: int) -> Callable[[], bool]:
    """Return what asks whether it is late only every so many times it is asked itself.

    So that many small subproblems count as a large one.
    """
    asked = count()
    known = False

    def late_by_now() -> bool:
        nonlocal known
        if not known and next(asked) % times == 0:
            known = cancelled()
        return known

    return late_by_now


def thread_seconds(seconds: float) -> TimeBudget:
    """Return so much of this thread's time, from now on."""
    return TimeBudget(time.thread_time() + seconds, time.thread_time)
