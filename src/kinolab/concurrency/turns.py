"""Long work that takes turns with other work: a thread that goes on only while it is waited for.

Only one of the two runs at any time, so that what comes of both does not depend on their speeds.
"""

from __future__ import annotations

import contextvars
import threading
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Turns(Generic[T]):
    """Work that may be left and gone on with wherever it calls ``pause``.

    Args:
        work: Done in a thread of its own; here and at once, where the system has no thread left.
    """

    def __init__(self, work: Callable[[], T]) -> None:
        self._work = work
        self._turn, self._back = threading.Semaphore(0), threading.Semaphore(0)
        self._result: list[T] = []
        self._error: BaseException | None = None
        self._over = self._closed = False
        run = contextvars.copy_context().run  # what is counted here is counted there, too
        self._thread: threading.Thread | None = threading.Thread(
            target=run, args=(self._run,), daemon=True
        )
        try:
            self._thread.start()
        except RuntimeError:
            self._thread = None

    def advance(self) -> bool:
        """Let the work go on to its next pause or its end; say whether that is its end."""
        if self._thread is None:
            self._do()
        if not self._over:
            self._turn.release()
            self._back.acquire()
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

    def pause(self) -> bool:
        """Wait for the next turn, if called by the work; say whether there will be none."""
        if threading.current_thread() is self._thread and not self._closed:
            self._back.release()
            self._turn.acquire()
        return self._closed

    def close(self) -> None:
        """Give the work no further turn; it is told so by ``pause``, and ends when it likes."""
        self._closed = True
        self._turn.release()

    def _run(self) -> None:
        self._turn.acquire()
        if not self._closed:
            self._do()
        self._back.release()

    def _do(self) -> None:
        try:
            self._result.append(self._work())
        except BaseException as error:  # told to whoever asks for the result
            self._error = error
        self._over = True
