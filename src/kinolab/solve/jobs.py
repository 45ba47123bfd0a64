"""Parallel search jobs, in processes or threads, as seen by the process that started them."""

from __future__ import annotations

import signal
import subprocess
import threading
from abc import ABC, abstractmethod
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import final

from kinolab.concurrency.process_worker import WorkerProcess
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.solve.plan import Attempt, Request
from kinolab.solve.solution_pool import SolutionPool
from kinolab.solve.worker import (
    INTERNAL,
    OUT_OF_MEMORY,
    Better,
    Failed,
    Found,
    Searching,
    search_and_tell,
    work,
)

INTERRUPTED = "interrupted."


class AbstractJob(ABC):
    """A search job and its progress.

    Args:
        connection: Receives its messages.
        request: The searches to make.

    Attributes:
        connection: Readable when a message is waiting or the job has exited.
        iterations: Total of all its searches so far.
        seconds: Search time so far.
        over: Whether it will send no more messages.
        failure: Exit code of its failure, 0 if it has not failed.
    """

    def __init__(self, connection: Connection, request: Request, pool: SolutionPool) -> None:
        self.connection, self._pool = connection, pool
        self.iterations, self.seconds, self.over, self.failure = 0, 0.0, False, 0
        self._seeds = request.seeds()
        self._seed = next(self._seeds, None)  # of the current search; None when done
        self._finished = 0  # iterations of finished searches

    def hear(self) -> None:
        """Process one message."""
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
        """Ask it to end its search and send its result; a second call aborts the current stage."""

    @abstractmethod
    def kill(self) -> None:
        """Kill it unconditionally."""

    def drop(self, reason: str) -> None:
        """Kill it and discard its result; ``reason`` says why."""
        self.kill()
        self._note("ended", reason)

    @abstractmethod
    def close(self, reason: str) -> None:
        """Wait until it has exited; ``reason`` is recorded for an unfinished search."""

    @abstractmethod
    def _left(self) -> None:
        """Record how it ended after its connection closed."""

    def _fail(self, exit_code: int, reason: str) -> None:
        self.failure = exit_code
        self._note("failed", reason)

    def _note(self, status: str, detail: str) -> None:
        """Record how the current search ended, if any."""
        self.over = True
        if self._seed is not None:
            tried = max(self.iterations - self._finished, 0)
            attempt = Attempt(self._seed, status, tried, after=self.seconds, detail=detail)
            self._pool.attempts.append(attempt)


@final
class ProcessJob(AbstractJob):
    """A job in a process of its own.

    Args:
        request: The searches to make.

    Raises:
        InputError: If this platform cannot start such processes.
        OSError: If the system cannot start another process.
    """

    def __init__(self, parcel: bytes, request: Request, pool: SolutionPool) -> None:
        self._worker = WorkerProcess(work)
        super().__init__(self._worker.connection, request, pool)
        # Most problems exceed the pipe's buffer, and the process reads only once it has started.
        self._worker.post((request, parcel))
        self._asked = False

    def end_search(self) -> None:
        """Ask it to end its search and send its result; a second call aborts the current stage."""
        self._asked = True
        self._worker.process.terminate()

    def kill(self) -> None:
        """Kill it unconditionally."""
        self._worker.process.kill()

    def close(self, reason: str) -> None:
        """Wait until it has exited; ``reason`` is recorded for an unfinished search."""
        self._worker.end()
        if not self.over:
            self._note("ended", reason)

    def _left(self) -> None:
        """Record how the process ended after its connection closed."""
        with suppress(subprocess.TimeoutExpired):
            self._worker.process.wait(5.0)  # [s] for a process to exit after its last message
        code = self._worker.process.returncode
        if code == 0:  # out of time; the next seed was not begun
            self.over = True
        elif self._asked and code == -signal.SIGTERM:
            self._note("ended", INTERRUPTED)
        else:
            self._fail(*_failure(code))


def _failure(code: int | None) -> tuple[int, str]:
    """Return the exit code and message for a process that exited abnormally."""
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
    """A job in a thread, for planners that release the GIL.

    It starts at once and shares the compiled kernels, the machine and the world, which a process
    has to load again.

    Args:
        problem: The planning problem, shared between threads.
        request: The searches to make.

    Raises:
        OSError: If the system cannot start another thread.
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
        """Ask it to end its search and send its result."""
        self._asked = True
        self._pass_on()

    def kill(self) -> None:
        """Let it end at its next budget check and do nothing more."""
        self._asked = self._killed = True
        self._pass_on()

    def close(self, reason: str) -> None:
        """Wait briefly for it to exit; ``reason`` is recorded for an unfinished search."""
        self.connection.close()  # its next message fails, which ends it
        self._thread.join(0.2)  # [s] for a thread to exit; after that it ends in the background
        if not self.over:
            self._note("ended", reason)

    def _left(self) -> None:
        self.over = True  # out of time; the next seed was not begun

    def _search(self, connection: Connection, problem: PlanningTask, request: Request) -> None:
        with connection, suppress(BrokenPipeError, ConnectionResetError):
            search_and_tell(connection, lambda: problem, request, self._watch)

    def _watch(self, budget: Budget) -> None:
        """Pass a stop request on to a search that begins."""
        self._budget = budget
        self._pass_on()

    def _pass_on(self) -> None:
        budget = self._budget
        if budget is not None:
            budget.abandoned = budget.abandoned or self._killed
            budget.interrupted = budget.interrupted or self._asked
