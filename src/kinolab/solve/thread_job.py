"""A thread that searches, seen by the one that started it.

For planners that release the interpreter's lock while they search: a thread begins at once and has
the compiled loops, the machine and the world already, where a process loads all of it anew.
"""

from __future__ import annotations

import threading
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import final

from kinolab.problem import Problem
from kinolab.search import Budget
from kinolab.solve.abstract_job import AbstractJob
from kinolab.solve.request import Request
from kinolab.solve.solution_pool import SolutionPool
from kinolab.solve.worker import search_and_tell

EXIT_SECONDS = 0.2  # [s] for a thread to leave; what it is still busy with ends by itself


@final
class ThreadJob(AbstractJob):
    """A thread, and what it has told.

    Args:
        problem: What to solve; threads share it.
        request: What to search for.
        pool: Where its plans go.

    Raises:
        OSError: If the system has no room for one more.
    """

    def __init__(self, problem: Problem, request: Request, pool: SolutionPool) -> None:
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
        self._thread.join(EXIT_SECONDS)
        if not self.over:
            self._note("ended", reason)

    def _left(self) -> None:
        self.over = True  # it used up its time; the next seed was not begun

    def _search(self, connection: Connection, problem: Problem, request: Request) -> None:
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
