"""What Ctrl-C does to a command, whatever the command is busy with.

The first one leaves at once where nothing would be lost. A search is asked to end instead and keeps
what it has; it is urged where that takes long, and before a second is over the process leaves in
any case. The second Ctrl-C leaves at once.

A thread hears the signal too: libraries that swallow KeyboardInterrupt while they import or
compile, and native code that Python's own handler has to wait for, make no difference to it. Where
native code stops all threads, machine code of our own ends the process.
"""

from __future__ import annotations

import math
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, NoReturn

EXIT_CODE = 130
STDERR = 2
URGE_SECONDS = 0.3  # [s] after Ctrl-C a search is urged to end
LEAVE_SECONDS = 0.7  # [s] after Ctrl-C the process leaves
ONE_PRESS = 0.1  # [s] in which a signal may come twice, from the terminal and from who started us
WRITING_SECONDS = 1.0  # [s] more that it takes at most to complete the files of a run


class Interrupts:
    """How Ctrl-C is taken at the moment.

    Attributes:
        seen: Whether there was one.
    """

    def __init__(self) -> None:
        self.seen = False
        self._end: Callable[[], None] | None = None
        self._asked = self._writing = False
        self._last = -ONE_PRESS  # when the signal came last, in [s]
        self._postpone: Callable[[float], None] = lambda _: None
        self._reader: int | None = None  # of the pipe by which the thread hears signals

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Take Ctrl-C inside by KeyboardInterrupt at most: for a command inside a program."""
        in_main_thread = threading.current_thread() is threading.main_thread()
        if self._reader is not None or not in_main_thread:
            yield
            return
        self.seen, self._asked, self._last = False, False, -ONE_PRESS
        before = signal.signal(signal.SIGINT, self._arrive)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)

    def guard(self) -> None:
        """Take Ctrl-C from now on, for a process that is this command alone."""
        signal.signal(signal.SIGINT, self._arrive)
        sys.unraisablehook = _say_unless_interrupted
        if sys.platform == "win32":
            return  # no pipe wakes a thread there, so that KeyboardInterrupt has to do
        self._reader, writer = os.pipe()
        os.set_blocking(writer, False)
        signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
        threading.Thread(target=self._watch, args=(self._reader,), daemon=True).start()

    def libraries_loaded(self) -> None:
        """Take care of native code that holds the interpreter's lock, now that there is some."""
        if self._reader is not None:
            from kinolab.cli import last_resort

            last_resort.arm(EXIT_CODE)
            self._postpone = last_resort.postpone

    def ask(self, end: Callable[[], None]) -> None:
        """Let Ctrl-C call a function from now on, which may raise, and again to urge."""
        self._end = end

    @contextmanager
    def asking(self) -> Iterator[None]:
        """Ask nobody any more after this."""
        try:
            yield
        finally:
            self._end = None

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Let no process leave inside that could complete what it writes."""
        self._writing = True
        if self.seen:
            self._postpone(WRITING_SECONDS)
        try:
            yield
        finally:
            self._writing = False

    def raise_if_seen(self) -> None:
        """Raise again what a library may have swallowed; called between stages."""
        if self.seen and not self._asked:
            raise KeyboardInterrupt

    def leave(self, exit_code: int = EXIT_CODE) -> NoReturn:
        """End this process and all that it started, without coming back to what it was doing."""
        patience = time.monotonic() + WRITING_SECONDS
        while self._writing and time.monotonic() < patience:
            time.sleep(0.005)
        _clear_up()
        os._exit(exit_code)

    def _arrive(self, *_: Any) -> None:
        """Handle the signal, in the main thread."""
        self.seen, before, self._last = True, self._last, time.monotonic()
        if self._last < before + ONE_PRESS:
            return
        if self._writing:
            self._postpone(WRITING_SECONDS)
        if self._end is not None:
            self._asked = True
            self._end()
        elif self._reader is None:
            raise KeyboardInterrupt

    def _watch(self, reader: int) -> None:
        """Leave in time, in a thread of its own."""
        _heard(reader, None)
        self.seen = True
        if self._end is not None:
            time.sleep(ONE_PRESS)
            _forget(reader)
            if not _heard(reader, URGE_SECONDS - ONE_PRESS):
                signal.pthread_kill(_main_thread(), signal.SIGINT)
                time.sleep(ONE_PRESS)
                _forget(reader)
                _heard(reader, LEAVE_SECONDS - URGE_SECONDS - ONE_PRESS)
        with suppress(OSError):
            os.write(STDERR, b"\ninterrupted\n")
        self.leave()


INTERRUPTS = Interrupts()  # signals belong to the process


def _heard(reader: int, seconds: float | None) -> bool:
    """Wait for Ctrl-C, for some seconds at most, and say whether there was one."""
    until = math.inf if seconds is None else time.monotonic() + seconds
    while True:
        left = until - time.monotonic()
        ready, _, _ = select.select([reader], [], [], None if seconds is None else max(left, 0.0))
        if not ready:
            return False
        if os.read(reader, 1)[0] == signal.SIGINT:  # and no other signal
            return True


def _forget(reader: int) -> None:
    """Take what was heard for the Ctrl-C before."""
    while _heard(reader, 0.0):
        pass


def _main_thread() -> int:
    identity = threading.main_thread().ident
    assert identity is not None, "it has been started"
    return identity


def _clear_up() -> None:
    """End all processes that this one started, and remove what is half written."""
    processes = sys.modules.get("kinolab.solve.processes")
    if processes:
        processes.kill_all()
    files = sys.modules.get("kinolab.files")
    if files:
        files.discard_drafts()


def _say_unless_interrupted(unraisable: sys.UnraisableHookArgs) -> None:
    """Say what Python cannot raise, but nothing of Ctrl-C, which has its effect all the same."""
    if not issubclass(unraisable.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(unraisable)
