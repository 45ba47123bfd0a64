"""What a planner is: settings, one method, and a result that may be a failure."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from contextlib import contextmanager
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from kinolab.errors import InputError, Mistake, unknown_name
from kinolab.settings import OLD_NAMES, setting, settings_of, with_default

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from kinolab.problem import Problem
    from kinolab.search.graph import SearchGraph

__all__ = [
    "AbstractPlanner",
    "Array",
    "Budget",
    "Outcome",
    "SearchResult",
    "setting",
    "with_default",
]

Array: TypeAlias = NDArray[np.float64]
T = TypeVar("T")

PICTURE_PERIOD = 0.5  # [s] between two pictures of what is explored
READY = 30.0  # [s] to get ready that do not count: code is loaded, on a slow computer, too
PICTURE_COST_FACTOR = 4.0  # times what a picture takes, at least, until the next


class Outcome(Enum):
    """How a search ended; the value is the sentence the user reads."""

    SOLVED = "Found a trajectory into the goal region."
    APPROXIMATE = "Did not reach the goal; the nearest approach is kept."
    NOT_FOUND = "Found no motion that comes nearer to the goal than the start."
    LOCAL_MINIMUM = (
        "Stuck in a local minimum of the potential; the nearest approach is kept. "
        "Raise [planner] random_walk_escapes or set navigation = true."
    )
    INTERRUPTED = "Interrupted; the nearest approach is kept."


@dataclass(frozen=True)
class SearchResult:
    """What a search found.

    Attributes:
        outcome: How it ended.
        t: Times of the knots in [s], shape (N+1,); a single 0 where nothing was found.
        u: Inputs per interval, shape (N, nu).
        iterations: Number of extensions tried.
        statistics: Numbers worth reporting, by name.
        rejections: Share of all refused motions, by cause and by who is to blame.
        graph: What it explored, None where a planner keeps nothing of the kind.
    """

    outcome: Outcome
    t: Array
    u: Array
    iterations: int
    statistics: Mapping[str, float] = field(default_factory=dict)
    rejections: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    graph: SearchGraph | None = None


@dataclass
class Budget:
    """How long a search may take; a planner asks ``spent`` once per iteration.

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

    @property
    def late(self) -> bool:
        """Whether not even the iteration that is being made may go on; asking counts nothing."""
        return self.interrupted or self.elapsed > self.time_limit

    @property
    def over(self) -> bool:
        """Whether no further iteration may be made; asking counts nothing."""
        too_many = self.max_iterations is not None and self.iterations >= self.max_iterations
        return too_many or self.late

    @property
    def left(self) -> float:
        """How many iterations may still be made; infinite without a limit."""
        return math.inf if self.max_iterations is None else self.max_iterations - self.iterations

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


@dataclass(frozen=True, kw_only=True)
class AbstractPlanner(ABC):
    """A search for a trajectory: its fields are its settings.

    A subclass is a frozen dataclass with a ``name``, defaults for all its settings, and ``solve``.

    Attributes:
        name: What a scenario writes after ``[planner] name =``.
        in_threads: Whether several searches may run in threads of one process: ``solve`` writes to
            nothing that they share, and releases the interpreter's lock for most of the time.
    """

    name: ClassVar[str]
    in_threads: ClassVar[bool] = False

    @abstractmethod
    def solve(self, problem: Problem, seed: int, budget: Budget) -> SearchResult:
        """Search for inputs that bring the machine from the start into the goal region.

        Not finding any is a result; only a wrong question raises.
        """

    @classmethod
    def from_settings(cls, settings: Mapping[str, Any]) -> Self:
        """Make a planner from the keys of a scenario.

        Raises:
            InputError: With every unknown key and every value that does not fit.
        """
        mistakes = [
            Mistake(f"[planner] {key}", what, remedy) for key, what, remedy in cls.misfits(settings)
        ]
        if mistakes:
            raise InputError(mistakes)
        return cls(**settings)

    @classmethod
    def misfits(cls, settings: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
        """Yield (key, what is wrong, what would work) of settings that do not fit."""
        known = {entry.name: entry for entry in settings_of(cls)}
        for key, value in settings.items():
            if key not in known and OLD_NAMES.get(key) in known:
                yield key, f"{key!r} is called {OLD_NAMES[key]!r} now.", "Write the new name."
            elif key not in known:
                unknown = unknown_name(f"setting of {cls.name}", key, known=sorted(known))
                yield key, unknown.what, unknown.remedy
            elif misfit := known[key].misfit(value):
                yield key, *misfit
        sound = {k: v for k, v in settings.items() if k in known and known[k].accepts(v)}
        yield from cls(**sound).conflicts()

    def conflicts(self) -> Iterator[tuple[str, str, str]]:
        """Yield (key, what is wrong, what would work) of settings that contradict each other."""
        yield from ()
