"""Compile all parts in several processes if possible, as numba compiles in one thread."""

from __future__ import annotations

import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait

from kinolab.cli.warm_up_parts import PARTS
from kinolab.concurrency.process_worker import WorkerProcess
from kinolab.concurrency.processors import processors
from kinolab.errors import KinolabError
from kinolab.numerics.compiling import Compilation, compilation


@dataclass(frozen=True)
class Warmed:
    """Progress or result of compiling a part.

    Attributes:
        part: Its name.
        functions: Number of functions compiled; 0 if all were cached on disk.
        seconds: Time spent compiling them, in [s].
        done: Whether the part is complete.
        failure: Why it could not be compiled; empty if it could.
    """

    part: str
    functions: int
    seconds: float
    done: bool = False
    failure: str = ""


class WarmUpError(KinolabError):
    """A part could not be compiled."""

    exit_code = 70


def warm_up(
    parts: Sequence[str] = tuple(PARTS),
    jobs: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> Iterator[Warmed]:
    """Compile what is not cached on disk, and yield the result of each part.

    Args:
        parts: Names of ``PARTS``.
        jobs: Maximum number of processes; the number of processors if left out.
        progress: Called periodically with the number of functions compiled in all parts.

    Raises:
        WarmUpError: If a part could not be compiled.
    """
    jobs = min(len(parts), jobs or processors())
    begun: dict[str, int] = {}
    alone = jobs <= 1 or sys.platform == "win32"
    told = (_compiled(part, lambda _: None) for part in parts) if alone else _at_once(parts, jobs)
    for news in told:
        begun[news.part] = news.functions
        if news.failure:
            raise WarmUpError(f"{news.part}: {news.failure}")
        if news.done:
            yield news
        elif progress:
            progress(sum(begun.values()))


def _at_once(parts: Sequence[str], jobs: int) -> Iterator[Warmed]:
    """Yield the reports of several processes, each of which compiles part after part."""
    left = list(parts)[::-1]
    with ExitStack() as ending:
        working = [ending.enter_context(WorkerProcess(work)).connection for _ in range(jobs)]
        for connection in working:
            connection.send(left.pop())
        while working:
            for ready in wait(working):
                assert isinstance(ready, Connection)
                try:
                    news = ready.recv()
                except EOFError:
                    raise WarmUpError("a process that compiles was ended.") from None
                yield news
                if news.done and left:
                    ready.send(left.pop())
                elif news.done:
                    working.remove(ready)


def work(connection: Connection) -> None:
    """Compile the parts that come by a connection."""
    while True:
        connection.send(_compiled(connection.recv(), connection.send))


def _compiled(part: str, tell: Callable[[Warmed], None]) -> Warmed:
    """Compile a part, and report progress."""
    last = time.monotonic()

    def told(so_far: Compilation) -> None:
        nonlocal last
        if time.monotonic() > last + 0.25:  # [s] between two reports of one process
            last = time.monotonic()
            tell(Warmed(part, so_far.functions, so_far.seconds))

    with compilation(told) as done:
        try:
            PARTS[part]()
        except Exception:
            failure = traceback.format_exc()
            return Warmed(part, done.functions, done.seconds, done=True, failure=failure)
    return Warmed(part, done.functions, done.seconds, done=True)
