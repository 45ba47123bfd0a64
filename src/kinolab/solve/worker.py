"""A process or a thread that searches for another one, and what it tells.

A process ignores Ctrl-C, which a terminal sends to all processes of a command: the one that
started it decides. That one ends a search by SIGTERM, which keeps what was found, and a process by
SIGKILL.
"""

from __future__ import annotations

import os
import pickle
import signal
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait

from kinolab.errors import KinolabError
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.solve.plan import PlanResult, Request, make_planner
from kinolab.solve.sequential_runs import sequential_runs

OUT_OF_MEMORY, INTERNAL = 6, 70  # exit codes


@dataclass(frozen=True)
class Searching:
    """How far it is, in all its searches together."""

    iterations: int
    seconds: float


@dataclass(frozen=True)
class Better:
    """It has a verified plan, the best one so far with this seed, and goes on to improve it."""

    plan: PlanResult


@dataclass(frozen=True)
class Found:
    """A search is over."""

    plan: PlanResult
    after: float  # [s] since its first search began


@dataclass(frozen=True)
class Failed:
    """It cannot go on."""

    exit_code: int
    reason: str


def enter(handle: int) -> None:
    """Be such a process, from beginning to end.

    Args:
        handle: The file descriptor of the connection to the process that started this one.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    connection = Connection(handle)
    with suppress(EOFError, BrokenPipeError):
        request, parcel = connection.recv()
        threading.Thread(target=_leave_with, args=(connection,), daemon=True).start()
        work(connection, request, parcel)
    os._exit(0)  # libraries take their time to say goodbye, and OMPL's binding complains


def work(connection: Connection, request: Request, parcel: bytes) -> None:
    """Search, and tell everything through a connection.

    Args:
        connection: To the process that wants to know.
        request: What to search for.
        parcel: The problem, pickled.
    """

    def heed(budget: Budget) -> None:
        signal.signal(signal.SIGTERM, lambda *_: budget.end())

    search_and_tell(connection, lambda: pickle.loads(parcel), request, heed)


def search_and_tell(
    connection: Connection,
    problem: Callable[[], PlanningTask],
    request: Request,
    heed: Callable[[Budget], None],
) -> None:
    """Search, and tell everything through a connection, failures included.

    Args:
        connection: To the one that wants to know.
        problem: Gives what to solve.
        request: What to search for.
        heed: Called with the budget before each search, so that it can be interrupted.
    """
    try:
        _search(connection, problem(), request, heed)
    except (BrokenPipeError, ConnectionResetError):
        raise  # nobody wants to know any more
    except MemoryError:
        connection.send(Failed(OUT_OF_MEMORY, "it ran out of memory."))
    except KinolabError as error:
        connection.send(Failed(error.exit_code, str(error)))
    except Exception:
        connection.send(Failed(INTERNAL, traceback.format_exc()))


def _search(
    connection: Connection, problem: PlanningTask, request: Request, heed: Callable[[Budget], None]
) -> None:
    searcher = make_planner(problem, request.planner, request.settings)
    for found, after in sequential_runs(
        problem,
        searcher,
        request,
        progress=lambda iterations, seconds: connection.send(Searching(iterations, seconds)),
        watch=heed,
        better=lambda plan: connection.send(Better(plan)),
    ):
        connection.send(Found(found, after))


def _leave_with(connection: Connection) -> None:
    """Leave no orphan: the other side says nothing more, and what can be read is its end."""
    wait([connection])
    os._exit(1)
