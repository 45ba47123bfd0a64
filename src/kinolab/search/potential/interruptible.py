"""Run compiled work so that interrupts are still handled."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future, wait
from typing import TypeVar

T = TypeVar("T")


def run_unless_cancelled(work: Callable[[], T], stop: Callable[[], bool]) -> T | None:
    """Return the result of ``work``, or None as soon as ``stop`` returns True.

    Python handles signals in its main thread and only between bytecodes, so long compiled work runs
    in another thread. Cancelled work finishes in the background and is discarded.
    """
    done: Future[T] = Future()

    def run() -> None:
        try:
            done.set_result(work())
        except BaseException as error:
            done.set_exception(error)

    threading.Thread(target=run, daemon=True).start()
    while not wait([done], 0.05).done:  # [s] between cancellation checks
        if stop():
            return None
    return done.result()
