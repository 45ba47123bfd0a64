"""What numba is compiling: a function that comes from its cache on disk is not, and is not told."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from numba.core.event import Event, Listener, install_listener

KIND = "numba:compile"


class Compilation(Listener):  # type: ignore[misc]
    """Counts what is compiled.

    Args:
        told: Called whenever a function is begun; one may be begun while another is not done.

    Attributes:
        functions: Begun so far.
    """

    def __init__(self, told: Callable[[Compilation], None] | None = None) -> None:
        self.functions = 0
        self._told, self._open = told, 0
        self._spent = self._begun = 0.0

    @property
    def seconds(self) -> float:
        """Spent on compiling so far."""
        return self._spent + (time.monotonic() - self._begun if self._open else 0.0)

    def on_start(self, _event: Event) -> None:
        """Count a function."""
        if not self._open:
            self._begun = time.monotonic()
        self._open += 1
        self.functions += 1
        if self._told:
            self._told(self)

    def on_end(self, _event: Event) -> None:
        """Stop the clock after the last one."""
        self._open -= 1
        if not self._open:
            self._spent += time.monotonic() - self._begun


@contextmanager
def compilation(told: Callable[[Compilation], None] | None = None) -> Iterator[Compilation]:
    """Count what is compiled inside, in any thread of this process."""
    counted = Compilation(told)
    with install_listener(KIND, counted):
        yield counted


def running(functions: int, seconds: float) -> str:
    """Word how far compiling is, for somebody who waits for it."""
    many = f"{functions} function{'' if functions == 1 else 's'}"
    return f"compiling inner loops, once on this computer: {seconds:.0f} s, {many} …"
