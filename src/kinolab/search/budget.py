"""Budget of a search or an optimisation: time, iterations and cancellation."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal, TypeVar

from kinolab.concurrency.cancel import CancellationToken, never_cancelled
from kinolab.search.graph import SearchGraph

T = TypeVar("T")

LATE = 1.0  # [s] after its end until a search that does not ask is named
READY = 30.0  # [s] of preparation that do not count, such as loading code on a slow computer


@dataclass
class Budget:
    """Termination condition: a time limit, an iteration limit and a cancellation token.

    A planner calls ``spent`` once per iteration, and passes ``expired`` as the cancellation token
    to long operations within one.

    Attributes:
        time_limit: In [s].
        max_iterations: None for no limit.
        progress: Called about four times a second with the iterations and seconds so far.
        viewer: Called about twice a second with the search graph, by planners that provide it.
        stage: Called with the name of each stage that begins: search, simulate, verify.
        told: Called now and then with what is done after the search, in words.
        interrupted: Set from outside to end the search soon.
        improve: Seconds after its first motion for which a planner may search for shorter ones;
            None for the scenario's.
        below: Duration in [s] of a known motion; a planner may prune what cannot be shorter. One
            that improves its motions finds only shorter ones.
        patience: Seconds without a shorter motion after which ``improve`` ends early.
        refused: Number of motions with the same seed that the verifier has refused.
        abandoned: Set from outside when the result is no longer wanted.
        iterations: Iterations so far.
        started: Clock time from which time counts.
        prepared: Seconds of preparation, which do not count.
        asked: Seconds of searching after which it was asked last whether it is spent.
        clock: Returns the time in [s].
        compiled: Returns the seconds spent on compilation, which never count.
        cancelled: Cancellation token of the caller.
    """

    time_limit: float
    max_iterations: int | None = None
    progress: Callable[[int, float], None] | None = None
    viewer: Callable[[SearchGraph], None] | None = None
    stage: Callable[[str], None] | None = None
    told: Callable[[str], None] | None = None
    interrupted: bool = False
    improve: float | Literal["auto"] | None = None
    below: float = math.inf
    patience: float = math.inf
    refused: int = 0
    abandoned: bool = False
    iterations: int = 0
    started: float = math.nan  # now by default
    prepared: float = 0.0
    asked: float = 0.0
    clock: Callable[[], float] = time.monotonic
    compiled: Callable[[], float] = lambda: 0.0
    cancelled: CancellationToken = never_cancelled
    _next_report: float = 0.25
    _next_look: float = 0.0
    _calls: int = 0  # of ``end``
    _patience: float = float("inf")  # calls of ``end`` before running work is aborted
    _broken: bool = False

    def __post_init__(self) -> None:
        if math.isnan(self.started):
            self.started = self.clock()

    def restart(self) -> None:
        """Restart the clock, once a planner is prepared.

        Preparation other than compilation still counts as far as it exceeds the limit and READY.
        """
        now = self.clock()
        taken = now - self.started
        self.prepared += taken
        self.started = now - max(0.0, taken - self.compiled() - max(READY, self.time_limit))

    @contextmanager
    def preparing(self) -> Iterator[None]:
        """Count the time inside as preparation, though the search has begun."""
        begun = self.clock()
        try:
            yield
        finally:
            taken = self.clock() - begun
            self.prepared += taken
            self.started += taken

    def end(self) -> None:
        """End the search soon; called by signal handlers, repeatedly if it takes long."""
        self.interrupted = True
        self._calls += 1
        if self._calls > self._patience:
            self._broken = True
            raise KeyboardInterrupt

    def breaking(self, work: Callable[[], T], *, patience: int = 0) -> T | None:
        """Run work that ``end`` may abort by an exception; None if it did.

        Args:
            work: Long work that may be aborted at any line.
            patience: Calls of ``end`` before that happens, for work that checks ``interrupted``.
        """
        before, self._broken = self._patience, False
        try:
            self._patience = patience
            return work()
        except BaseException:  # a library may have converted the interrupt
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
        """Say whether even the current iteration must end; counts nothing."""
        self.asked = self.elapsed
        return self.interrupted or self.asked > self.time_limit or self.cancelled()

    @property
    def unasked(self) -> bool:
        """Whether its time has been over for ``LATE`` and the search has not asked since."""
        return self.elapsed > self.time_limit + LATE and self.asked <= self.time_limit

    @property
    def over(self) -> bool:
        """Whether no further iteration may be made; counts nothing."""
        too_many = self.max_iterations is not None and self.iterations >= self.max_iterations
        return too_many or self.expired()

    @property
    def left(self) -> float:
        """Iterations left; infinite without a limit."""
        return math.inf if self.max_iterations is None else self.max_iterations - self.iterations

    @property
    def unspent(self) -> float:
        """Iterations left if they are limited, otherwise seconds left."""
        return self.time_limit - self.elapsed if self.max_iterations is None else self.left

    def fraction(self, fraction: float = 1.0) -> Callable[[], float]:
        """Return a function for how much of a fraction of ``unspent`` is spent, 1 for all of it.

        It is called before each subproblem and counts an iteration.
        """
        before = self.unspent

        def spent() -> float:
            if before <= 0 or self.spent():
                return math.inf
            return (before - self.unspent) / (fraction * before)

        return spent

    def spend(self, iterations: int) -> None:
        """Count a batch of iterations."""
        self.iterations += iterations
        if self.progress and (elapsed := self.elapsed) > self._next_report:
            self._next_report = elapsed + 0.25
            self.progress(self.iterations, elapsed)

    def take_back(self) -> None:
        """Uncount an unfinished iteration, so that the count reproduces the search."""
        self.iterations -= 1

    def spent(self) -> bool:
        """Say whether the search must end, and count one more iteration if not."""
        if self.over:
            return True
        self.spend(1)
        return False

    def show(self, explored: Callable[[], SearchGraph]) -> None:
        """Send the search graph to the viewer, if there is one and a snapshot is due."""
        if self.viewer and (elapsed := self.elapsed) > self._next_look:
            self.viewer(explored())
            # half a second between snapshots of the graph, or four times what they cost
            self._next_look = self.elapsed + max(0.5, 4.0 * (self.elapsed - elapsed))
