"""A process that searches, seen by the one that started it."""

from __future__ import annotations

import signal
import subprocess
import threading
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import final

from kinolab.solve.abstract_job import INTERRUPTED, AbstractJob
from kinolab.solve.processes import bury, start_process
from kinolab.solve.request import Request
from kinolab.solve.solution_pool import SolutionPool
from kinolab.solve.worker import INTERNAL, OUT_OF_MEMORY

EXIT_SECONDS = 5.0  # [s] for a process that has told everything to leave


@final
class Job(AbstractJob):
    """A process, and what it has told.

    Args:
        parcel: The problem, pickled.
        request: What to search for.
        pool: Where its plans go.

    Raises:
        InputError: If this platform cannot start such processes.
        OSError: If the system has no room for one more.
    """

    def __init__(self, parcel: bytes, request: Request, pool: SolutionPool) -> None:
        self._process, connection = start_process()
        super().__init__(connection, request, pool)
        # The pipe is smaller than most problems, and the process reads only once it is awake.
        deliver = threading.Thread(target=_deliver, args=(connection, request, parcel))
        deliver.daemon = True
        deliver.start()
        self._delivery, self._asked = deliver, False

    def end_search(self) -> None:
        """Ask it to end its search and tell what it has; urge it, the second time."""
        self._asked = True
        self._process.terminate()

    def kill(self) -> None:
        """End it, whatever it is doing."""
        self._process.kill()

    def close(self, reason: str) -> None:
        """Wait until it has left; ``reason`` says why a search was not finished, if any was not."""
        bury(self._process)
        self._delivery.join()  # nobody reads any more, which ends it
        self.connection.close()
        if not self.over:
            self._note("ended", reason)

    def _left(self) -> None:
        """See how a process ended that tells nothing more."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(EXIT_SECONDS)
        code = self._process.returncode
        if code == 0:  # it used up its time; the next seed was not begun
            self.over = True
        elif self._asked and code == -signal.SIGTERM:
            self._note("ended", INTERRUPTED)
        else:
            self._fail(*_failure(code))


def _deliver(connection: Connection, request: Request, parcel: bytes) -> None:
    with suppress(OSError):  # the process has left, which its silence tells
        connection.send((request, parcel))


def _failure(code: int | None) -> tuple[int, str]:
    """Return the exit code and the words for a process that left with an exit code of its own."""
    if code is None:
        return INTERNAL, "its process has fallen silent."
    if code >= 0:
        return INTERNAL, f"its process ended with exit code {code}."
    name = signal.Signals(-code).name
    if name == "SIGKILL":
        return OUT_OF_MEMORY, "its process was killed, as happens where memory runs out."
    return INTERNAL, f"its process was ended by {name}."
