"""Waits for compiled work without turning a deaf ear to interrupts."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

CANCELLATION_PERIOD = 0.05  # [s] between two looks at whether to stop


def run_unless_cancelled(work: Callable[[], T], stop: Callable[[], bool]) -> T | None:
    """Return what ``work`` returns, or None as soon as ``stop`` says to end.

    Python handles signals in its main thread, and only between two of its own instructions; so
    what takes seconds elsewhere runs beside it. What was given up ends by itself, unheard.
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
