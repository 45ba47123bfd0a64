"""Threads that work ahead of whoever takes their results, in order and not far."""

from __future__ import annotations

import os
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeVar

from kinolab.concurrency.processors import processors
from kinolab.concurrency.submitting import submitted

T = TypeVar("T")
R = TypeVar("R")


@dataclass(frozen=True)
class Share:
    """What a crew may take of the computer.

    Args:
        threads: How many work at once; with one, nothing is done ahead.
        others_first: Whether they get what others leave, where the system tells threads apart.
    """

    threads: int
    others_first: bool = False


def everything() -> Share:
    """All processors, like others."""
    return Share(processors())


class Crew:
    """Some threads, for work that mostly releases Python's lock: compiled loops, compression.

    Args:
        share: What they may take, asked again and again.
    """

    def __init__(self, share: Callable[[], Share] = everything) -> None:
        self._share = share
        self._usual = ThreadPoolExecutor(processors())
        self._modest = ThreadPoolExecutor(processors(), initializer=_let_others_first)

    def __enter__(self) -> Crew:
        return self

    def __exit__(self, *_: object) -> None:
        for pool in (self._usual, self._modest):
            pool.shutdown(cancel_futures=True)

    def do(self, work: Callable[[T], R], item: T) -> R:
        """Apply a function to one item."""
        return next(self.in_order(work, [item]))

    def in_order(self, work: Callable[[T], R], items: Iterable[T]) -> Iterator[R]:
        """Apply a function to each item; as many results as there are threads wait to be taken."""
        waiting: deque[Future[R]] = deque()
        try:
            for item in items:
                share = self._share()
                pool = self._modest if share.others_first else self._usual
                waiting.append(submitted(pool, work, item))
                while len(waiting) > (share.threads if share.threads > 1 else 0):
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for future in waiting:
                future.cancel()


def _let_others_first() -> None:
    if sys.platform == "linux":  # elsewhere it would be the whole process, and for good
        with suppress(OSError):
            # Niceness 10 of Linux: a tenth of the time of what else runs on a processor
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), 10)
