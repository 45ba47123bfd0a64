"""One of several processes that search, seen by the one that started it."""

from __future__ import annotations

import signal
import subprocess
import threading
from contextlib import suppress
from multiprocessing.connection import Connection

from kinolab.planning.findings import Findings
from kinolab.planning.messages import Failed, Found, Searching
from kinolab.planning.plan import Attempt
from kinolab.planning.processes import bury, start_process
from kinolab.planning.request import Request
from kinolab.planning.worker import INTERNAL, OUT_OF_MEMORY

PATIENCE = 5.0  # [s] for a process that has told everything to leave
INTERRUPTED = "interrupted."


class Job:
    """A process, and what it has told.

    Args:
        parcel: The problem, pickled.
        request: What to search for.
        findings: Where its plans go.

    Attributes:
        connection: Readable when it has something to tell, or has left.
        iterations: Of all its searches so far.
        seconds: Of searching so far.
        over: Whether it will tell nothing more.
        failure: The exit code that its failure deserves, 0 where it has not failed.

    Raises:
        InputError: If this platform cannot start such processes.
        OSError: If the system has no room for one more.
    """

    def __init__(self, parcel: bytes, request: Request, findings: Findings) -> None:
        self._process, self.connection = start_process()
        # The pipe is smaller than most problems, and the process reads only once it is awake.
        deliver = threading.Thread(target=_deliver, args=(self.connection, request, parcel))
        deliver.daemon = True
        deliver.start()
        self._delivery, self._findings = deliver, findings
        self.iterations, self.seconds, self.over, self.failure = 0, 0.0, False, 0
        self._seeds = request.seeds()
        self._seed = next(self._seeds, None)  # it searches with; None when it is through
        self._finished = 0  # iterations of searches that are over
        self._asked = False

    def hear(self) -> None:
        """Take in one message."""
        try:
            message = self.connection.recv()
        except (EOFError, OSError):
            self._left()
            return
        match message:
            case Searching():
                self.iterations, self.seconds = message.iterations, message.seconds
            case Found():
                self._finished += message.plan.iterations
                self.iterations, self._seed = self._finished, next(self._seeds, None)
                self.over = self._seed is None
                self._findings.add(message.plan, message.after)
            case Failed():
                self._fail(message.exit_code, message.reason)

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
            self._process.wait(PATIENCE)
        code = self._process.returncode
        if code == 0:  # it used up its time; the next seed was not begun
            self.over = True
        elif self._asked and code == -signal.SIGTERM:
            self._note("ended", INTERRUPTED)
        else:
            self._fail(*_failure(code))

    def _fail(self, exit_code: int, reason: str) -> None:
        self.failure = exit_code
        self._note("failed", reason)

    def _note(self, status: str, detail: str) -> None:
        """Note how the search ended that was going on, if any was."""
        self.over = True
        if self._seed is not None:
            tried = max(self.iterations - self._finished, 0)
            attempt = Attempt(self._seed, status, tried, after=self.seconds, detail=detail)
            self._findings.attempts.append(attempt)


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
