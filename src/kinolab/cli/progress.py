"""What a command is doing, on stderr."""

from __future__ import annotations

import sys
import time

from kinolab.cli.interrupts import INTERRUPTS


class Progress:
    """Lines on stderr: one that is overwritten on a terminal, plain ones elsewhere."""

    def __init__(self, quiet: bool) -> None:
        self._quiet = quiet
        self._terminal = sys.stderr.isatty()
        self._last = 0.0

    def __call__(self, text: str, *, passing: bool = False) -> None:
        """Say what is happening; a passing line may be left out."""
        INTERRUPTS.raise_if_seen()
        if self._quiet or (passing and not self._terminal and time.monotonic() < self._last + 5):
            return
        self._last = time.monotonic()
        print(f"\r\033[K{text}" if self._terminal else text, end=self._end, file=sys.stderr)
        sys.stderr.flush()

    @property
    def _end(self) -> str:
        return "" if self._terminal else "\n"

    def close(self) -> None:
        """Clear the line on a terminal."""
        INTERRUPTS.raise_if_seen()
        if self._terminal and not self._quiet:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
