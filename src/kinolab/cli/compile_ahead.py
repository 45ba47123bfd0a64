"""A second process that compiles what a command needs later, while the command does the rest.

numba compiles in one thread. Both processes keep what they compile on disk, and each waits for a
function that the other one has in hand (`numerics/jit_cache.py`).
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from multiprocessing.connection import Connection


@contextmanager
def compiled_ahead() -> Iterator[None]:
    """Start the process inside once something must be compiled; end it on exit.

    A machine without a second processor, or Windows, does without.
    """
    from kinolab.concurrency.process_worker import WorkerProcess
    from kinolab.concurrency.processors import processors
    from kinolab.numerics.compiling import Compilation, compilation

    started: list[WorkerProcess] = []

    def start(_: Compilation) -> None:
        if not started:
            with suppress(OSError):  # no process can be had: everything is compiled here
                started.append(ending.enter_context(WorkerProcess(work)))

    if sys.platform == "win32" or processors() < 2:
        yield
        return
    with ExitStack() as ending, compilation(start):
        yield


def work(starter: Connection) -> None:
    """Compile in a process of its own, until that is done or the one that started it ends."""
    from kinolab.concurrency.process_worker import leave_with

    leave_with(starter)
    for part in in_order():
        with suppress(Exception):  # the command will say what is wrong
            part()


def in_order() -> tuple[Callable[[], object], ...]:
    """Return what to run, as a command with the default planner needs it.

    Left to the command is what it begins with: the grid of distances, and trees in flat outputs.
    """
    from kinolab.cli.warm_up_parts import PARTS, simulated

    return _trees, simulated, PARTS["optimisation"], PARTS["pictures"]


def _trees() -> None:
    from kinolab.cli.warm_up_parts import small_problem
    from kinolab.planners.auto import MEMBERS
    from kinolab.search.tree import search_state
    from kinolab.world import World

    problem = small_problem()
    empty = replace(problem, world=World((), True, problem.world.bounds))  # no grid of distances
    for member in MEMBERS:
        tree = member().extension(empty, search_state(empty, 1.0, 1))
        tree.grow(0)
        tree.begin()
