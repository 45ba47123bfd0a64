"""Workers: other processes, connected by a pipe and shielded from Ctrl-C.

They are fresh interpreters, not forks, since native libraries do not survive a fork; and unlike
those of ``multiprocessing`` they do not re-import the user's script.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from queue import SimpleQueue
from typing import Any, NoReturn, Self

from kinolab.errors import InputError, Mistake

ENTRY = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from kinolab.concurrency.process_worker import serve; from {module} import {task}; "
    "serve(int(sys.argv[2]), {task})"
)

_running: set[subprocess.Popen[bytes]] = set()


class WorkerProcess:
    """A process that does a task for this one; a context manager that ends it.

    Args:
        task: A function, or its module and name where it is not to be imported here. It is called
            there with the other end of the connection; once that is closed, whatever it tells or
            waits for ends it.

    Raises:
        InputError: If this platform cannot inherit a connection.
        OSError: If the system cannot start another process.
    """

    def __init__(self, task: Callable[[Connection], None] | tuple[str, str]) -> None:
        if sys.platform == "win32":
            what = "several processes are not to be had on Windows."
            raise InputError([Mistake("jobs", what, "Use jobs=1.")])
        ours, theirs = Pipe()
        module, name = task if isinstance(task, tuple) else (task.__module__, task.__name__)
        code = ENTRY.format(module=module, task=name)
        command = [sys.executable, "-c", code, json.dumps(sys.path), str(theirs.fileno())]
        try:
            with theirs, _deaf_to_interrupts():
                self.process = subprocess.Popen(  # with all output to stderr: stdout has the result
                    command, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL, stdout=2
                )
                _running.add(self.process)
        except BaseException:
            ours.close()
            raise
        self.connection = ours
        self._outbox: SimpleQueue[Any] = SimpleQueue()
        self._posting: threading.Thread | None = None

    def post(self, message: Any) -> None:
        """Send a message, in the order of others, without waiting until the process reads it."""
        if self._posting is None:
            self._posting = threading.Thread(target=self._post, daemon=True)
            self._posting.start()
        self._outbox.put(message)

    def _post(self) -> None:
        with suppress(OSError):  # it has ended, as its closed connection shows
            while (message := self._outbox.get()) is not None:
                self.connection.send(message)

    def end(self) -> None:
        """End it, whatever it does."""
        self.process.kill()
        self.process.wait()
        _running.discard(self.process)
        if self._posting is not None:
            self._outbox.put(None)
            self._posting.join()
        self.connection.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()


def kill_all() -> None:
    """Kill all processes, for exits that skip the usual clean-up."""
    for process in tuple(_running):
        process.kill()
    for process in tuple(_running):
        process.wait()


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Block SIGINT, so that processes started here are shielded before they can ignore it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def serve(handle: int, work: Callable[[Connection], None]) -> NoReturn:
    """Do the work of a process that a ``WorkerProcess`` has started, in that process, and leave.

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

    def leave() -> NoReturn:
        wait([connection])  # nothing is sent, so readable means closed
        os._exit(1)

    threading.Thread(target=leave, daemon=True).start()
