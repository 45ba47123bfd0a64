"""Work for other threads, done here where no thread can be had."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")


def submitted(pool: Executor, work: Callable[[T], R], item: T) -> Future[R]:
    """Let a pool apply a function to an item; where the system gives it no thread, do so at once.

    The function may then be applied twice, should the pool have other threads after all.
    """
    try:
        return pool.submit(work, item)
    except RuntimeError as refused:  # threads and processes of a user are limited
        if "new thread" not in str(refused):  # or the pool is closed, which is a mistake
            raise
        done: Future[R] = Future()
        try:
            done.set_result(work(item))
        except BaseException as error:  # as in another thread: told to whoever takes the result
            done.set_exception(error)
        return done
