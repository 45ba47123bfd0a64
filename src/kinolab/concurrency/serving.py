"""What a process does that another one started: its work, while the other one is there."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from typing import NoReturn


def serve(handle: int, work: Callable[[Connection], None]) -> NoReturn:
    """Do the work of a process that a ``WorkingProcess`` has started, in that process, and leave.

    It ignores Ctrl-C, which a terminal sends to the whole process group: the process that started
    it decides, and ends it.

    Args:
        handle: File descriptor of the connection to the process that started it.
        work: Gets the connection, and is left without a word when that is closed.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(EOFError, BrokenPipeError, ConnectionResetError):
        work(Connection(handle))
    os._exit(0)  # skips slow clean-up of libraries, and complaints of OMPL's binding


def leave_with(connection: Connection) -> None:
    """Leave when the process that started this one is gone, from now on; it may send no more."""
    threading.Thread(target=_leave_with, args=(connection,), daemon=True).start()


def _leave_with(connection: Connection) -> NoReturn:
    wait([connection])  # nothing is sent, so readable means closed
    os._exit(1)
