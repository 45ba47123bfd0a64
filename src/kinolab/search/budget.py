"""How long a search or an optimisation may take, and who may end it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeVar

from kinolab.cancel import CancellationToken, never_cancelled
from kinolab.search.graph import SearchGraph

T = TypeVar("T")

PICTURE_PERIOD = 0.5  # [s] between two pictures of what is explored
READY = 30.0  # [s] to get ready that do not count: code is loaded, on a slow computer, too
PICTURE_COST_FACTOR = 4.0  # times what a picture takes, at least, until the next


@dataclass
class Budget:
    """How long work may take: a cancellation token, a time limit and a number of iterations.

    A planner asks ``spent`` once per iteration, and passes ``expired`` on as the token of what
    takes long within one.

    Attributes:
        time_limit: In [s].
        max_iterations: None for no limit.
        progress: Called about four times a second with the iterations and the seconds so far.
        viewer: Called about twice a second with what was explored so far, by planners that can say.
        interrupted: Set from outside to end the search soon.
        improve: Seconds after its first motion in which a planner may itself look for shorter ones;
            None for those of the scenario.
        below: Duration in [s]; there is a motion as short already, and a planner may leave out what
            cannot be shorter.
        abandoned: Set from outside where nobody wants to know any more what was found.
        iterations: Made so far.
        started: When the time began to count, by the clock.
        prepared: Seconds apart from it, in which a planner got everything it needs.
        clock: Tells the time in [s].
        compiled: Tells how many seconds were spent on compiling, which never count.
        cancelled: Says that somebody else wants it to end.
    """

    time_limit: float
    max_iterations: int | None = None
    progress: Callable[[int, float], None] | None = None
    viewer: Callable[[SearchGraph], None] | None = None
    interrupted: bool = False
    improve: float | None = None
    below: float = math.inf
    abandoned: bool = False
    iterations: int = 0
    started: float = math.nan  # now, where it is not given
    prepared: float = 0.0
    clock: Callable[[], float] = time.monotonic
    compiled: Callable[[], float] = lambda: 0.0
    cancelled: CancellationToken = never_cancelled
    _next_report: float = 0.25
    _next_look: float = 0.0
    _calls: int = 0  # of ``end``
    _patience: float = float("inf")  # calls of ``end`` that do not break off what is running
    _broken: bool = False

    def __post_init__(self) -> None:
        if math.isnan(self.started):
            self.started = self.clock()

    def restart(self) -> None:
        """Begin to count the time now, when a planner has everything it needs.

        What it took to build the world and the like counts where it is more than the whole limit.
        """
        now = self.clock()
        taken = now - self.started
        self.prepared += taken
        self.started = now - max(0.0, taken - self.compiled() - max(READY, self.time_limit))

    @contextmanager
    def preparing(self) -> Iterator[None]:
        """Count what is compiled or loaded inside as preparation, though the search has begun."""
        begun = self.clock()
        try:
            yield
        finally:
            taken = self.clock() - begun
            self.prepared += taken
            self.started += taken

    def end(self) -> None:
        """End the search soon; a handler of signals calls this, and again where it takes long."""
        self.interrupted = True
        self._calls += 1
        if self._calls > self._patience:
            self._broken = True
            raise KeyboardInterrupt

    def breaking(self, work: Callable[[], T], *, patience: int = 0) -> T | None:
        """Return what work gives, None where ``end`` broke it off by an exception.

        Args:
            work: Takes long and may be given up at any line.
            patience: Calls of ``end`` before that happens, for work that looks at ``interrupted``.
        """
        before, self._broken = self._patience, False
        try:
            self._patience = patience
            return work()
        except BaseException:  # a library may have made something else of the interrupt
            if not self._broken:
                raise
            return None
        finally:
            self._patience, self._broken = before, False

    @property
    def elapsed(self) -> float:
        """Seconds of searching so far."""
        return self.clock() - self.started

    def expired(self) -> bool:
        """Say whether not even the iteration that is being made may go on; this counts nothing."""
        return self.interrupted or self.elapsed > self.time_limit or self.cancelled()

    @property
    def over(self) -> bool:
        """Whether no further iteration may be made; asking counts nothing."""
        too_many = self.max_iterations is not None and self.iterations >= self.max_iterations
        return too_many or self.expired()

    @property
    def left(self) -> float:
        """How many iterations may still be made; infinite without a limit."""
        return math.inf if self.max_iterations is None else self.max_iterations - self.iterations

    @property
    def unspent(self) -> float:
        """How many iterations are left where they are limited, else how many seconds."""
        return self.time_limit - self.elapsed if self.max_iterations is None else self.left

    def fraction(self, fraction: float = 1.0) -> Callable[[], float]:
        """Return what tells how much is spent of a fraction of ``unspent``: 1 where all of it is.

        It is asked before each subproblem, which counts as an iteration.
        """
        before = self.unspent

        def spent() -> float:
            if before <= 0 or self.spent():
                return math.inf
            return (before - self.unspent) / (fraction * before)

        return spent

    def spend(self, iterations: int) -> None:
        """Count iterations that were made at once."""
        self.iterations += iterations
        self._report()

    def take_back(self) -> None:
        """Count an iteration no more that was not finished: as many whole ones repeat a search."""
        self.iterations -= 1

    def spent(self) -> bool:
        """Say whether the search must end, and count one more iteration if not."""
        if self.over:
            return True
        self.spend(1)
        return False

    def show(self, explored: Callable[[], SearchGraph]) -> None:
        """Let somebody watch what is explored, if anybody does and it is time."""
        if self.viewer and (elapsed := self.elapsed) > self._next_look:
            self.viewer(explored())
            self._next_look = self.elapsed + max(
                PICTURE_PERIOD, PICTURE_COST_FACTOR * (self.elapsed - elapsed)
            )

    def _report(self) -> None:
        if self.progress and (elapsed := self.elapsed) > self._next_report:
            self._next_report = elapsed + 0.25
            self.progress(self.iterations, elapsed)
