"""Run compiled work so that interrupts are still handled."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

CANCELLATION_PERIOD = 0.05  # [s] between cancellation checks


def run_unless_cancelled(work: Callable[[], T], stop: Callable[[], bool]) -> T | None:
    """Return the result of ``work``, or None as soon as ``stop`` returns True.

    Python handles signals in its main thread and only between bytecodes, so long compiled work runs
    in another thread. Cancelled work finishes in the background and is discarded.
    """
    results: list[T] = []
    failures: list[BaseException] = []

    def run() -> None:
        try:
            results.append(work())
        except BaseException as error:
            failures.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(CANCELLATION_PERIOD)
        if thread.is_alive() and stop():
            return None
    if failures:
        raise failures[0]
    return results[0]
