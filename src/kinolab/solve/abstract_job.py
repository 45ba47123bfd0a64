"""One of several searches at once, seen by the one that started them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from multiprocessing.connection import Connection

from kinolab.solve.job_messages import Better, Failed, Found, Searching
from kinolab.solve.plan import Attempt
from kinolab.solve.request import Request
from kinolab.solve.solution_pool import SolutionPool

INTERRUPTED = "interrupted."


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
        self.connection, self._findings = connection, pool
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
                self._findings.compare(message.plan)
            case Found():
                self._finished += message.plan.iterations
                self.iterations, self._seed = self._finished, next(self._seeds, None)
                self.over = self._seed is None
                self._findings.add(message.plan, message.after)
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
            self._findings.attempts.append(attempt)
