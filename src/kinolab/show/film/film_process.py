"""A process that draws a film while the user looks at the plan.

It is told early that a film will be wanted, and imports what it needs while the plan is improved.
The film is made here: the process gets meshes and poses, and loads neither machine nor world.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing.connection import Connection
from types import TracebackType

from kinolab.errors import KinolabError
from kinolab.numerics.compiling import running
from kinolab.problem import PlanningTask
from kinolab.processes.starting import Process, bury, start_process
from kinolab.show.film.animation import animate, film_of
from kinolab.show.film.drawing import Compiling, DrawingFailed, Drawn
from kinolab.trajectory import Trajectory

MODULE = "kinolab.show.film.drawing"


class DrawingError(KinolabError):
    """The process that draws was ended from outside, as where memory is short."""

    exit_code = 6


class FilmProcess:
    """Draws one film; leaving the context ends its process, finished or not.

    Args:
        progress: Called with messages, if inner loops have to be compiled.
    """

    def __init__(self, progress: Callable[[str], None] = lambda _: None) -> None:
        self._progress = progress
        self._started: tuple[Process, Connection] | None = None
        self._result: Callable[[], bytes] | None = None

    def __enter__(self) -> FilmProcess:
        if sys.platform != "win32":
            with suppress(OSError):  # no room for another process
                self._started = start_process(MODULE)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        if self._started:
            process, connection = self._started
            self._started = None
            process.kill()
            bury(process)
            connection.close()

    def begin(self, problem: PlanningTask, trajectory: Trajectory) -> None:
        """Begin to draw a trajectory; without a process it is drawn by ``animation``.

        Raises:
            DrawingError: If the process was ended from outside.
        """
        if self._started is None:
            self._result = partial(animate, problem, trajectory)
            return
        _, connection = self._started
        with _ended():
            connection.send((film_of(problem, trajectory), problem.scenario.render.size))
        self._result = partial(self._received, connection)

    def animation(self) -> bytes:
        """Return what was begun as an animated GIF.

        Raises:
            DrawingError: If the process was ended from outside.
            MemoryError: If it had no memory left.
            RuntimeError: If drawing failed; the text has the process's own traceback.
        """
        assert self._result is not None
        with _ended():
            return self._result()

    def _received(self, connection: Connection) -> bytes:
        while True:
            match connection.recv():
                case Compiling(functions, seconds):
                    self._progress(running(functions, seconds))
                case Drawn(content):
                    return content
                case DrawingFailed(reason, of_memory):
                    raise MemoryError if of_memory else RuntimeError(reason)


@contextmanager
def _ended() -> Iterator[None]:
    """Say what a closed connection means."""
    try:
        yield
    except (EOFError, BrokenPipeError, ConnectionResetError):
        raise DrawingError("the process that draws the film was ended.") from None
