"""Progress of numba's compilation; functions loaded from its disk cache are not counted."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from numba.core.event import Event, Listener, install_listener

WAIT = "kinolab:wait"  # for another process that compiles

_counting: list[Compilation] = []


class Compilation(Listener):  # type: ignore[misc]
    """Counts compiled functions.

    Args:
        told: Called when the compilation of a function starts; compilations may nest.

    Attributes:
        functions: Number started so far, without those that another process compiles.
    """

    def __init__(self, told: Callable[[Compilation], None] | None = None) -> None:
        self.functions = 0
        self._told, self._open = told, 0
        self._spent = self._begun = 0.0

    @property
    def seconds(self) -> float:
        """Time spent compiling, and waiting for what others compile, so far, in [s]."""
        return self._spent + (time.monotonic() - self._begun if self._open else 0.0)

    def add(self, seconds: float) -> None:
        """Count seconds of another process."""
        self._spent += seconds

    def on_start(self, event: Event) -> None:
        """Count a function, or begin to wait for one."""
        if not self._open:
            self._begun = time.monotonic()
        self._open += 1
        if event.kind == WAIT:
            return
        self.functions += 1
        if self._told:
            self._told(self)

    def on_end(self, _event: Event) -> None:
        """Stop the clock after the outermost one."""
        self._open -= 1
        if not self._open:
            self._spent += time.monotonic() - self._begun


@contextmanager
def compilation(told: Callable[[Compilation], None] | None = None) -> Iterator[Compilation]:
    """Count functions compiled inside the context, in any thread of this process."""
    counted = Compilation(told)
    with install_listener("numba:compile", counted), install_listener(WAIT, counted):
        _counting.append(counted)
        try:
            yield counted
        finally:
            _counting.remove(counted)


def count_elsewhere(seconds: float) -> None:
    """Count what another process, for which this one has waited, took to compile, in [s]."""
    for counted in _counting:
        counted.add(seconds)


def running(functions: int, seconds: float) -> str:
    """Return a progress message about compilation."""
    many = f"{functions} function{'' if functions == 1 else 's'}"
    return f"compiling inner loops, once on this computer: {seconds:.0f} s, {many} …"
