"""A process that draws a film while the plan is improved, and while the user looks at it.

It is told of each better motion and begins to draw it; if that turns out to be the last one, the
film is under way or done. It gets meshes and poses, and loads neither machine nor world; and what
draws is not loaded here.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from multiprocessing.connection import Connection

import numpy as np

from kinolab.concurrency.processors import processors
from kinolab.concurrency.starting import WorkingProcess
from kinolab.errors import KinolabError
from kinolab.numerics.compiling import running
from kinolab.problem import PlanningTask
from kinolab.show.film.film_messages import Compiling, Drawn, Final, Order
from kinolab.show.film.picture import Picture
from kinolab.show.film.staging.motion_script import motion_script
from kinolab.trajectory import Trajectory

MODULE = "kinolab.show.film.drawing"


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
        self._worker: WorkingProcess | None = None
        self._ordered: Trajectory | None = None
        self._orders = 0
        self._still: Picture | None = None  # surfaces, which are the same in all orders
        self._result: Callable[[], bytes] | None = None

    def __enter__(self) -> FilmProcess:
        if sys.platform != "win32":
            with suppress(OSError):  # no room for another process
                self._worker = WorkingProcess(MODULE)
        return self

    def __exit__(self, *_: object) -> None:
        if self._worker:
            self._worker.end()
            self._worker = None

    def suggest(self, problem: PlanningTask, trajectory: Trajectory) -> None:
        """Begin to draw a trajectory that may be the last one, if a processor is idle.

        What goes wrong here is said when the film is wanted.
        """
        if self._worker and processors() > 1:
            with suppress(Exception):
                self._order(self._worker, problem, trajectory)

    def begin(self, problem: PlanningTask, trajectory: Trajectory) -> None:
        """Draw this trajectory; without a process it is drawn by ``animation``."""
        if self._worker is None:
            self._result = partial(_drawn_here, problem, trajectory)
            return
        if not _same(self._ordered, trajectory):
            self._order(self._worker, problem, trajectory)
        self._worker.post(Final())
        self._result = partial(self._received, self._worker.connection)

    def animation(self) -> bytes:
        """Return what was begun as an animated GIF.

        Raises:
            DrawingError: If the process was ended from outside.
            MemoryError: If it had no memory left.
            RuntimeError: If drawing failed; the text has the process's own traceback.
        """
        assert self._result is not None
        try:
            return self._result()
        except (EOFError, BrokenPipeError, ConnectionResetError):  # the connection was closed
            raise DrawingError("the process that draws the film was ended.") from None

    def _order(self, worker: WorkingProcess, problem: PlanningTask, trajectory: Trajectory) -> None:
        """Have a trajectory drawn, and nothing that was ordered before."""
        script = motion_script(problem, trajectory)
        if self._still is None:
            self._still = shown = script.picture.plain()
        else:
            shown = replace(script.picture, bodies=self._still.bodies, obstacles=())
        self._orders += 1
        worker.post(Order(self._orders, replace(script, picture=shown)))
        self._ordered = trajectory

    def _received(self, connection: Connection) -> bytes:
        while True:
            match connection.recv():
                case Compiling(functions, seconds):
                    self._progress(running(functions, seconds))
                case Drawn(number, content, reason) if number == self._orders:
                    if content is None:
                        raise RuntimeError(reason) if reason else MemoryError
                    return content


def _drawn_here(problem: PlanningTask, trajectory: Trajectory) -> bytes:
    from kinolab.show.film.animation import animate

    return animate(problem, trajectory)


def _same(ordered: Trajectory | None, wanted: Trajectory) -> bool:
    """Say whether a film shows what is wanted: the same states at the same times."""
    return ordered is not None and (
        np.array_equal(ordered.t, wanted.t) and np.array_equal(ordered.x, wanted.x)
    )
