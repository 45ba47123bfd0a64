"""Progress messages of a command on stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import click

from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.terminal import escaped
from kinolab.concurrency.stages import heard_by


class Progress:
    """Lines on stderr: one that is overwritten on a terminal, plain ones elsewhere.

    Until its command ends, it also shows what long computations do, in passing.
    """

    def __init__(self, quiet: bool) -> None:
        self._quiet = quiet
        self._terminal = sys.stderr.isatty()
        self._last = time.monotonic()
        self._listeners: list[Callable[[str], None]] = []
        if command := click.get_current_context(silent=True):
            command.with_resource(heard_by(lambda text: self(text, passing=True)))

    def __call__(self, text: str, *, passing: bool = False, lasting: bool = False) -> None:
        """Print a message.

        Args:
            passing: Whether it may be skipped.
            lasting: Whether it stays on the terminal, and is printed even if quiet.
        """
        INTERRUPTS.raise_if_seen()
        for listener in self._listeners:
            listener(text)
        if (self._quiet and not lasting) or (
            passing and not self._terminal and time.monotonic() < self._last + 5
        ):
            return
        self._last, text = time.monotonic(), escaped(text)
        end = "\n" if lasting or not self._terminal else ""
        print(f"\r\033[K{text}" if self._terminal else text, end=end, file=sys.stderr)
        sys.stderr.flush()

    @contextmanager
    def heard(self, listener: Callable[[str], None]) -> Iterator[None]:
        """Pass all messages inside to a listener, too."""
        self._listeners.append(listener)
        try:
            yield
        finally:
            self._listeners.remove(listener)

    def compiling(self) -> AbstractContextManager[object]:
        """Report progress of compilation inside, if anything must be compiled."""
        from kinolab.numerics.compiling import compilation, running

        return compilation(lambda done: self(running(done.functions, done.seconds), passing=True))

    def close(self) -> None:
        """Clear the line on a terminal."""
        INTERRUPTS.raise_if_seen()
        if self._terminal and not self._quiet:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
