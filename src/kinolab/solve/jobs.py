"""Several searches at once, each of them seen by the one that started it."""

from __future__ import annotations

import signal
import subprocess
import threading
from abc import ABC, abstractmethod
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import final

from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.solve.plan import Attempt, Request
from kinolab.solve.processes import bury, start_process
from kinolab.solve.solution_pool import SolutionPool
from kinolab.solve.worker import (
    INTERNAL,
    OUT_OF_MEMORY,
    Better,
    Failed,
    Found,
    Searching,
    search_and_tell,
)

INTERRUPTED = "interrupted."
PROCESS_EXIT_SECONDS = 5.0  # [s] for a process that has told everything to leave
# [s] for a thread to leave; what it is still busy with ends by itself
THREAD_EXIT_SECONDS = 0.2


class AbstractJob(ABC):
    """Who searches, and what has been told.

    Args:
        connection: By which it tells.
        request: What to search for.
        pool: Where its plans go.

    Attributes:
        connection: Readable when it has something to tell, or has left.
        iterations: Of all its searches so far.
        seconds: Of searching so far.
        over: Whether it will tell nothing more.
        failure: The exit code that its failure deserves, 0 where it has not failed.
    """

    def __init__(self, connection: Connection, request: Request, pool: SolutionPool) -> None:
        self.connection, self._pool = connection, pool
        self.iterations, self.seconds, self.over, self.failure = 0, 0.0, False, 0
        self._seeds = request.seeds()
        self._seed = next(self._seeds, None)  # it searches with; None when it is through
        self._finished = 0  # iterations of searches that are over

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
            case Better():
                self._pool.compare(message.plan)
            case Found():
                self._finished += message.plan.iterations
                self.iterations, self._seed = self._finished, next(self._seeds, None)
                self.over = self._seed is None
                self._pool.add(message.plan, message.after)
            case Failed():
                self._fail(message.exit_code, message.reason)

    @abstractmethod
    def end_search(self) -> None:
        """Ask it to end its search and tell what it has; urge it, the second time."""

    @abstractmethod
    def kill(self) -> None:
        """End it, whatever it is doing."""

    def drop(self, reason: str) -> None:
        """End it, and hear nothing more of what it has; ``reason`` says why."""
        self.kill()
        self._note("ended", reason)

    @abstractmethod
    def close(self, reason: str) -> None:
        """Wait until it has left; ``reason`` says why a search was not finished, if any was not."""

    @abstractmethod
    def _left(self) -> None:
        """See how it ended, now that it tells nothing more."""

    def _fail(self, exit_code: int, reason: str) -> None:
        self.failure = exit_code
        self._note("failed", reason)

    def _note(self, status: str, detail: str) -> None:
        """Note how the search ended that was going on, if any was."""
        self.over = True
        if self._seed is not None:
            tried = max(self.iterations - self._finished, 0)
            attempt = Attempt(self._seed, status, tried, after=self.seconds, detail=detail)
            self._pool.attempts.append(attempt)


@final
class ProcessJob(AbstractJob):
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
            self._process.wait(PROCESS_EXIT_SECONDS)
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


@final
class ThreadJob(AbstractJob):
    """A thread, and what it has told, for planners that release the interpreter's lock.

    It begins at once and has the compiled loops, the machine and the world already, where a process
    loads all of it anew.

    Args:
        problem: What to solve; threads share it.
        request: What to search for.
        pool: Where its plans go.

    Raises:
        OSError: If the system has no room for one more.
    """

    def __init__(self, problem: PlanningTask, request: Request, pool: SolutionPool) -> None:
        ours, theirs = Pipe()
        super().__init__(ours, request, pool)
        self._asked = self._killed = False
        self._budget: Budget | None = None
        self._thread = threading.Thread(target=self._search, args=(theirs, problem, request))
        self._thread.daemon = True
        try:
            self._thread.start()
        except RuntimeError as error:
            raise OSError(str(error)) from error

    def end_search(self) -> None:
        """Ask it to end its search and tell what it has."""
        self._asked = True
        self._pass_on()

    def kill(self) -> None:
        """Let it end at its next look at the budget, and do nothing more."""
        self._asked = self._killed = True
        self._pass_on()

    def close(self, reason: str) -> None:
        """Give it a moment to leave; ``reason`` says why a search was not finished, if any was."""
        self.connection.close()  # nobody listens any more, which ends what it tells
        self._thread.join(THREAD_EXIT_SECONDS)
        if not self.over:
            self._note("ended", reason)

    def _left(self) -> None:
        self.over = True  # it used up its time; the next seed was not begun

    def _search(self, connection: Connection, problem: PlanningTask, request: Request) -> None:
        with connection, suppress(BrokenPipeError, ConnectionResetError):
            search_and_tell(connection, lambda: problem, request, self._heed)

    def _heed(self, budget: Budget) -> None:
        """Let a search that begins be ended as well."""
        self._budget = budget
        self._pass_on()

    def _pass_on(self) -> None:
        budget = self._budget
        if budget is not None:
            budget.abandoned = budget.abandoned or self._killed
            budget.interrupted = budget.interrupted or self._asked
