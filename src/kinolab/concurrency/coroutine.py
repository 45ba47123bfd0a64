"""A coroutine made of a thread, which goes on only when it is told to.

Its caller may do something else meanwhile, and then waits until it has suspended itself: what comes
of both does not depend on how fast they are, as long as neither looks at what the other one is
doing. Unlike a generator, it may be left from any depth of its calls.

Source: Conway, Design of a separable transition-diagram compiler, Communications of the ACM 6(7),
1963.
"""

from __future__ import annotations

import contextvars
import threading
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Coroutine(Generic[T]):
    """Work that can be left wherever it calls ``suspend``, and resumed there.

    Args:
        work: Done in a thread of its own; here and at once, where the system has no thread left.

    Attributes:
        closed: Whether the work is to end.
    """

    def __init__(self, work: Callable[[], T]) -> None:
        self._work = work
        self._turn, self._back = threading.Semaphore(0), threading.Semaphore(0)
        self._result: list[T] = []
        self._error: BaseException | None = None
        self._over = self._going = False
        self.closed = False
        run = contextvars.copy_context().run  # what is counted here is counted there, too
        self._thread: threading.Thread | None = threading.Thread(
            target=run, args=(self._run,), daemon=True
        )
        try:
            self._thread.start()
        except RuntimeError:
            self._thread = None

    def resume(self) -> None:
        """Let the work go on until it suspends itself or ends, unless it is over."""
        if self._thread is None and not self._over:
            self._do()
        if not self._over:
            self._going = True
            self._turn.release()

    def wait(self, seconds: float = threading.TIMEOUT_MAX) -> bool:
        """Wait until the work has suspended itself or ended; say whether it is over.

        Args:
            seconds: To wait at most.
        """
        if self._going and self._back.acquire(timeout=min(seconds, threading.TIMEOUT_MAX)):
            self._going = False
        return self._over

    @property
    def result(self) -> T:
        """What came of the work that is over.

        Raises:
            Exception: Whatever the work raised.
        """
        if self._error is not None:
            raise self._error
        return self._result[0]

    def suspend(self) -> bool:
        """Wait to be resumed, if called by the work; say whether it is to end instead."""
        if threading.current_thread() is self._thread and not self.closed:
            self._back.release()
            self._turn.acquire()
        return self.closed

    def close(self) -> None:
        """Tell the work by ``suspend`` that it is to end, and wait until it has."""
        self.closed = True
        self._turn.release()
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        self._turn.acquire()
        if not self.closed:
            self._do()
        self._back.release()

    def _do(self) -> None:
        try:
            self._result.append(self._work())
        except BaseException as error:  # told to whoever asks for the result
            self._error = error
        self._over = True
