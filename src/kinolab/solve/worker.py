"""Worker side of a parallel search, and the messages it sends to its parent.

The parent ends a search by SIGTERM, which keeps what was found, and a process by SIGKILL.
"""

from __future__ import annotations

import pickle
import signal
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection

from kinolab.concurrency.process_worker import leave_with
from kinolab.errors import KinolabError
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.solve.plan import Listeners, PlanResult, Request, make_planner
from kinolab.solve.sequential_runs import sequential_runs

OUT_OF_MEMORY, INTERNAL = 6, 70  # exit codes


@dataclass(frozen=True)
class Searching:
    """Progress message, summed over all its searches."""

    iterations: int
    seconds: float


@dataclass(frozen=True)
class Better:
    """A verified plan, the best so far with this seed; the worker goes on to improve it."""

    plan: PlanResult


@dataclass(frozen=True)
class Found:
    """A search has finished."""

    plan: PlanResult
    after: float  # [s] since its first search began


@dataclass(frozen=True)
class Failed:
    """The worker has failed."""

    exit_code: int
    reason: str


def work(connection: Connection) -> None:
    """Search as the parent process asks by a connection, and send it messages."""
    request, parcel = connection.recv()
    leave_with(connection)

    def watch(budget: Budget) -> None:
        signal.signal(signal.SIGTERM, lambda *_: budget.end())

    search_and_tell(connection, lambda: pickle.loads(parcel), request, watch)


def search_and_tell(
    connection: Connection,
    problem: Callable[[], PlanningTask],
    request: Request,
    watch: Callable[[Budget], None],
) -> None:
    """Search, and send all messages, including failures.

    Args:
        connection: To the parent.
        problem: Returns the planning problem.
        request: The searches to make.
        watch: Called with the budget before each search, so that it can be interrupted.
    """
    try:
        _search(connection, problem(), request, watch)
    except (BrokenPipeError, ConnectionResetError):
        raise  # the parent has closed the connection
    except MemoryError:
        connection.send(Failed(OUT_OF_MEMORY, "it ran out of memory."))
    except KinolabError as error:
        connection.send(Failed(error.exit_code, str(error)))
    except Exception:
        connection.send(Failed(INTERNAL, traceback.format_exc()))


def _search(
    connection: Connection, problem: PlanningTask, request: Request, watch: Callable[[Budget], None]
) -> None:
    searcher = make_planner(problem, request.planner, request.settings)
    listeners = Listeners(
        progress=lambda iterations, seconds: connection.send(Searching(iterations, seconds)),
        watch=watch,
        improved=lambda plan: connection.send(Better(plan)),
    )
    for found, after in sequential_runs(problem, searcher, request, listeners):
        connection.send(Found(found, after))
