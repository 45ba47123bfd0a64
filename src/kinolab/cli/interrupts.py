"""Handling of Ctrl-C, whatever a command is doing.

The first Ctrl-C exits at once if nothing would be lost. A search is asked to end instead and keeps
its result; it is asked again if that takes long, and within a second the process exits in any case.
The second Ctrl-C exits at once.

All of this is done in Python's signal handlers, so that libraries which swallow KeyboardInterrupt
while importing or compiling have no effect; a process in native code that blocks Python is killed
by its parent (`supervisor`).
"""

from __future__ import annotations

import mmap
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, NoReturn

EXIT_CODE = 130
STDERR = 2
INTERRUPTED = b"\ninterrupted\n"  # on stderr, when the process exits at once
URGE_SECONDS = 0.3  # [s] after Ctrl-C a search is asked again to end
ONE_PRESS = 0.1  # [s] in which a signal may come twice, from terminal and parent


class Interrupts:
    """State of Ctrl-C handling.

    Attributes:
        seen: Whether there was one.
        is_writing: One byte, not 0 while files of a run are written; shared with the parent.
        shares_fate: The same while several searches are in this process, which all end if native
            code crashes in one of them.
        after_crash: Whether this process does again what another one did, which crashed so.
    """

    def __init__(self) -> None:
        self.seen = False
        self.is_writing = mmap.mmap(-1, 1)
        self.shares_fate = mmap.mmap(-1, 1)
        self.after_crash = False
        self._end: Callable[[], None] | None = None
        self._alone = self._asked = self._urged = self._leaving = False
        self._last = -ONE_PRESS  # when the signal came last, in [s]

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Handle Ctrl-C inside by KeyboardInterrupt at most, for use as a library."""
        if self._alone or threading.current_thread() is not threading.main_thread():
            yield
            return
        self.seen, self._asked, self._last = False, False, -ONE_PRESS
        before = signal.signal(signal.SIGINT, self._arrive)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)

    def guard(self) -> None:
        """Handle Ctrl-C from now on, in a process that runs this command only."""
        sys.unraisablehook = _say_unless_interrupted
        if sys.platform != "win32":  # without timers, KeyboardInterrupt must suffice
            self._alone = True
            signal.signal(signal.SIGALRM, self._ring)
        signal.signal(signal.SIGINT, self._arrive)

    def ask(self, end: Callable[[], None]) -> None:
        """Let Ctrl-C call ``end`` from now on, which may raise, and repeatedly."""
        self._end = end

    @contextmanager
    def asking(self) -> Iterator[None]:
        """Unset the function of ``ask`` on exit."""
        try:
            yield
        finally:
            self._end = None

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Defer the exit of the process until what is written inside is complete."""
        self.is_writing[0] = 1
        try:
            yield
        finally:
            self.is_writing[0] = 0
            if self._leaving:
                self._leave_unless_writing()

    @contextmanager
    def sharing_fate(self, several: bool) -> Iterator[None]:
        """Have the command done again, each search in a process, if native code crashes inside.

        Args:
            several: Whether there are searches that go on then.
        """
        self.shares_fate[0] = several
        try:
            yield
        finally:
            self.shares_fate[0] = 0

    def raise_if_seen(self) -> None:
        """Raise KeyboardInterrupt again if a library swallowed it; called between stages."""
        if self.seen and not self._asked:
            raise KeyboardInterrupt

    def leave(self, exit_code: int = EXIT_CODE) -> NoReturn:
        """Exit this process and all that it started, without unwinding the stack.

        Half-written files are removed.
        """
        for kind in ("process_worker", "forks"):
            if processes := sys.modules.get(f"kinolab.concurrency.{kind}"):
                processes.kill_all()
        if files := sys.modules.get("kinolab.files"):
            files.discard_drafts()
        os._exit(exit_code)

    def _arrive(self, *_: Any) -> None:
        """Handle Ctrl-C."""
        self.seen, before, self._last = True, self._last, time.monotonic()
        if self._last < before + ONE_PRESS:
            return
        if self._alone and (self._asked or self._end is None):
            self._leave_unless_writing()
        elif self._end is None:
            raise KeyboardInterrupt
        else:
            self._asked = True
            if self._alone:
                # 0.7 [s] after Ctrl-C the process exits
                signal.setitimer(signal.ITIMER_REAL, URGE_SECONDS, 0.7 - URGE_SECONDS)
            self._end()

    def _ring(self, *_: Any) -> None:
        """Handle the timer: ask again at first, then exit."""
        urged, self._urged = self._urged, True
        if urged:
            self._leave_unless_writing()
        elif self._end is not None:
            self._end()

    def _leave_unless_writing(self) -> None:
        """Exit at once, or as soon as what is being written is complete."""
        self._leaving = True
        if not self.is_writing[0]:
            with suppress(OSError):
                os.write(STDERR, INTERRUPTED)
            self.leave()


INTERRUPTS = Interrupts()  # signals belong to the process


def _say_unless_interrupted(unraisable: sys.UnraisableHookArgs) -> None:
    """Report unraisable exceptions, except KeyboardInterrupt, which is handled anyway."""
    if not issubclass(unraisable.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(unraisable)
