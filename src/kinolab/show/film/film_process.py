"""A process that draws films while the plan is improved, and while the user looks at the page.

It is told of each better motion, and draws the newest whenever it has finished a film: the first
one is there soon, however often there is a better one. If what it draws turns out to be the last,
the film is under way or done. It gets meshes and poses, and loads neither machine nor world; and
what draws is not loaded here.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from multiprocessing.connection import Connection

import numpy as np

from kinolab.concurrency.process_worker import WorkerProcess
from kinolab.concurrency.processors import processors
from kinolab.errors import KinolabError
from kinolab.numerics.compiling import running
from kinolab.problem import PlanningTask
from kinolab.show.film.film_messages import Compiling, Drawn, Final, Order
from kinolab.show.film.staging.script_writing import motion_script
from kinolab.show.scene.picture import Picture
from kinolab.trajectory import Trajectory

DRAWING = ("kinolab.show.film.drawing", "work")  # which is not imported here


class DrawingError(KinolabError):
    """The process that draws was ended from outside, as where memory is short."""

    exit_code = 6


class FilmProcess:
    """Draws a film; leaving the context ends its process, finished or not.

    Args:
        progress: Called with messages, if inner loops have to be compiled.
    """

    def __init__(self, progress: Callable[[str], None] = lambda _: None) -> None:
        self._progress = progress
        self._worker: WorkerProcess | None = None
        self._ordered: Trajectory | None = None
        self._orders = 0
        self._still: Picture | None = None  # surfaces, which are the same in all orders
        self._result: Callable[[], bytes] | None = None
        self._wanted: dict[int, Callable[[bytes], None]] = {}  # who gets a film, by its order
        self._news = threading.Condition()  # of what the process has said last:
        self._compiling: Compiling | None = None
        self._drawn: Drawn | None = None
        self._ended = False

    def __enter__(self) -> FilmProcess:
        if sys.platform != "win32":
            with suppress(OSError):  # no room for another process
                self._worker = WorkerProcess(DRAWING)
        if self._worker:
            self._listener = threading.Thread(target=self._listen, args=(self._worker.connection,))
            self._listener.daemon = True
            try:
                self._listener.start()
            except RuntimeError:  # nor for a thread
                self._worker.end()
                self._worker = None
        return self

    def __exit__(self, *_: object) -> None:
        if self._worker:
            self._worker.process.kill()
            self._listener.join()  # before its connection is closed
            self._worker.end()
            self._worker = None

    @property
    def draws_ahead(self) -> bool:
        """Whether suggestions are drawn: there are a process and a second processor."""
        return self._worker is not None and not self._ended and processors() > 1

    def suggest(
        self,
        problem: PlanningTask,
        trajectory: Trajectory,
        drawn: Callable[[bytes], None] = lambda _: None,
    ) -> None:
        """Have a trajectory drawn that may be the last one, if a processor is idle.

        What goes wrong here is said when the film is wanted.

        Args:
            trajectory: The motion.
            drawn: Called with its film, in another thread; not if a newer one is begun instead.
        """
        if self._worker and self.draws_ahead:
            with suppress(Exception):
                self._order(self._worker, problem, trajectory, drawn)

    def begin(self, problem: PlanningTask, trajectory: Trajectory) -> bytes | None:
        """Draw this trajectory; return its film if it is finished already.

        Without a process it is drawn by ``animation``.
        """
        if self._worker is None:
            self._result = partial(_drawn_here, problem, trajectory)
            return None
        if not _same(self._ordered, trajectory):
            self._order(self._worker, problem, trajectory)
        self._worker.post(Final())
        self._result = self._received
        with self._news:
            return self._drawn.content if self._drawn and self._is_last(self._drawn) else None

    def animation(self) -> bytes:
        """Return what was begun as an animated GIF.

        Raises:
            DrawingError: If the process was ended from outside.
            MemoryError: If it had no memory left.
            RuntimeError: If drawing failed; the text has the process's own traceback.
        """
        assert self._result is not None
        return self._result()

    def _order(
        self,
        worker: WorkerProcess,
        problem: PlanningTask,
        trajectory: Trajectory,
        drawn: Callable[[bytes], None] = lambda _: None,
    ) -> None:
        """Have a trajectory drawn, after the one that is under way unless this one is final."""
        script = motion_script(problem, trajectory)
        if self._still is None:
            self._still = shown = script.picture.plain()
        else:
            shown = replace(script.picture, bodies=self._still.bodies, obstacles=())
        with self._news:
            self._orders += 1
            self._wanted[self._orders] = drawn
        worker.post(Order(self._orders, replace(script, picture=shown)))
        self._ordered = trajectory

    def _listen(self, connection: Connection) -> None:
        """Hear what the process says, in a thread of its own, until it has ended."""
        with suppress(EOFError, OSError):
            while True:
                message, wanted = connection.recv(), None
                with self._news:
                    match message:
                        case Compiling():
                            self._compiling = message
                        case Drawn(number):
                            self._drawn, wanted = message, self._wanted.get(number)
                            self._wanted = {n: w for n, w in self._wanted.items() if n > number}
                    self._news.notify_all()
                if wanted and message.content is not None:
                    wanted(message.content)
        with self._news:
            self._ended = True
            self._news.notify_all()

    def _received(self) -> bytes:
        """Wait for the film that was ordered last."""
        with self._news:
            while not (self._drawn and self._is_last(self._drawn)):
                if self._ended:
                    raise DrawingError("the process that draws the film was ended.")
                if self._compiling:
                    self._progress(running(self._compiling.functions, self._compiling.seconds))
                self._news.wait()
            content, reason = self._drawn.content, self._drawn.reason
        if content is None:
            raise RuntimeError(reason) if reason else MemoryError
        return content

    def _is_last(self, drawn: Drawn) -> bool:
        return drawn.number == self._orders


def _drawn_here(problem: PlanningTask, trajectory: Trajectory) -> bytes:
    from kinolab.show.film.animation import animate

    return animate(problem, trajectory)


def _same(ordered: Trajectory | None, wanted: Trajectory) -> bool:
    """Say whether a film shows what is wanted: the same states at the same times."""
    return ordered is not None and (
        np.array_equal(ordered.t, wanted.t) and np.array_equal(ordered.x, wanted.x)
    )
