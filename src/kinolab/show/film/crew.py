"""Threads that work ahead of whoever takes their results, in order and not far."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from kinolab.processes.processors import processors

T = TypeVar("T")
R = TypeVar("R")


class Crew:
    """Some threads, for work that mostly releases Python's lock: compiled loops, compression.

    Args:
        threads: How many may work at once, asked again and again; with one, nothing is done ahead.
    """

    def __init__(self, threads: Callable[[], int] = processors) -> None:
        self._threads = threads
        self._pool = ThreadPoolExecutor(processors())

    def __enter__(self) -> Crew:
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    def in_order(self, work: Callable[[T], R], items: Iterable[T]) -> Iterator[R]:
        """Apply a function to each item; as many results as there are threads wait to be taken."""
        waiting: deque[Future[R]] = deque()
        try:
            for item in items:
                if self._threads() > 1 or waiting:
                    waiting.append(self._pool.submit(work, item))
                else:
                    yield work(item)
                while len(waiting) > self._threads():
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for future in waiting:
                future.cancel()
