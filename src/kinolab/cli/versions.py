"""Versions of a run: while a plan is improved, its folder has one that is complete by itself.

The first motion is there to be looked at as soon as it has been verified: on a page at once, and in
a film when that has been drawn. Plan, page and film of a folder always show the same motion: a
better one replaces all of them together.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinolab.cli.interrupts import INTERRUPTS

if TYPE_CHECKING:
    from kinolab.problem import PlanningTask
    from kinolab.show.film.film_process import FilmProcess
    from kinolab.solve import PlanResult
    from kinolab.trajectory import Trajectory


class Versions:
    """Writes versions of a run into its folder, each in place of the one before.

    Args:
        problem: What is planned.
        film: Returns the process that draws, always the same; None where no pictures are wanted.
        ahead: Whether a processor is left to draw films while the plan is improved.

    Attributes:
        pictured: Whether pictures are wanted.
        report: Of the version that is in the folder.
    """

    def __init__(
        self,
        problem: PlanningTask,
        folder: Path,
        film: Callable[[], FilmProcess] | None,
        *,
        ahead: bool = False,
    ) -> None:
        self._problem, self._folder, self._film, self._ahead = problem, folder, film, ahead
        self.pictured = film is not None
        self.report: dict[str, Any] = {}
        self._written: PlanResult | None = None
        self._complete = True  # whether its film is there, if there is to be one
        self._views: dict[str, bytes] = {}  # of the motion and the facts that were shown last
        self._shown: tuple[Trajectory | None, dict[str, Any]] = (None, {})
        self._next = 0.0  # by the clock, in [s], when another version may be written
        self._lock, self._over = threading.RLock(), False  # films come in another thread

    def improved(self, found: PlanResult) -> Path | None:
        """Take a verified plan, better than those before; of the first one, return what shows it.

        The first is written at once. Others wait for their films, so that no film goes before the
        next one is there; where none is drawn yet, they are written as time allows.

        Raises:
            OSError: If the plan cannot be written. What is wrong with its pictures is said at the
                end.
        """
        from kinolab.runs import PAGE

        with self._lock:
            first, drawn_later = self._written is None, self._suggest(found)
            if first or not self._film:
                self._write(found, pictured=False)  # which takes no longer than a moment
            if self._film and (first or not drawn_later):
                self._write_if_due(found)
        page = self._folder / PAGE
        return (page if self._film and page.is_file() else self._folder) if first else None

    def end(self, found: PlanResult) -> bool:
        """Write the final plan with its pictures; say whether nothing is missing, such as its film.

        Raises:
            Exception: What is wrong with the pictures; the plan has been written without them.
        """

        def keep() -> None:
            """Write the plan at once, if it is not there: its pictures may take too long."""
            there = self._written and self._written.trajectory is found.trajectory
            if not (there or INTERRUPTS.is_writing[0]):
                self._write(found, pictured=False)

        with self._lock, INTERRUPTS.asking():
            self._over = True  # earlier films come too late
            INTERRUPTS.ask(keep)
            if INTERRUPTS.seen or not self._written:
                keep()
            if error := self._write(found, self._begun, pictured=found.trajectory is not None):
                raise error
        return self._complete

    def wait_for_film(self) -> bool:
        """Add the film of the final plan; say whether the folder still has its run."""
        assert self._film
        return self._add_film(self._film().animation())

    def _suggest(self, found: PlanResult) -> bool:
        """Have the film of a plan drawn that may be the last one, if a processor is idle."""
        film = self._film() if self._film else None  # which begins to load what it needs
        if film is None or not self._ahead or found.trajectory is None:
            return False
        film.suggest(self._problem, found.trajectory, partial(self._drawn, found))
        return film.draws_ahead

    def _begun(self, found: PlanResult) -> bytes | None:
        """Have the film of the final plan drawn; return it if it is finished."""
        assert self._film
        assert found.trajectory is not None
        return self._film().begin(self._problem, found.trajectory)

    def _drawn(self, found: PlanResult, animation: bytes) -> None:
        """Take the film of a plan that may have been written without it, or not at all."""
        with self._lock, suppress(Exception):  # what is wrong is said at the end
            if found is self._written and not self._over:
                self._add_film(animation)
            elif not self._over:
                self._write_if_due(found, animation)

    def _write_if_due(self, found: PlanResult, animation: bytes | None = None) -> None:
        """Write a version if that is cheap; what is wrong with its pictures is said at the end."""
        if time.monotonic() >= self._next:
            self._write(found, lambda _: animation)

    def _write(
        self,
        found: PlanResult,
        film: Callable[[PlanResult], bytes | None] = lambda _: None,
        *,
        pictured: bool = True,
    ) -> Exception | None:
        """Write a plan with its pictures, or at least without; return what is wrong with them.

        Args:
            film: Returns its film, if that is finished.
            pictured: Whether there are to be pictures; only if any are wanted.
        """
        from kinolab.runs import write_run

        pictured = pictured and self._film is not None
        if pictured:
            import kinolab.show.scene.scenes  # noqa: F401  # which takes its time once in any case

        begun, error = time.monotonic(), None

        def pictures(report: dict[str, Any]) -> dict[str, bytes]:
            if INTERRUPTS.seen:  # what has been asked for by then is waited for
                writing.enter_context(INTERRUPTS.writing())
            drawn = self._pictures(found, film, report) if pictured else {}
            writing.enter_context(INTERRUPTS.writing())
            return drawn

        with ExitStack() as writing:
            try:
                self.report = write_run(self._folder, self._problem, found, pictures)
            except Exception as raised:
                error, pictured = raised, False
                self.report = write_run(self._folder, self._problem, found, pictures)
        self._written, ended = found, time.monotonic()
        if pictured:
            # At most 0.05 of the time of improving is for writing versions after the first one.
            self._next = ended + (ended - begun) / 0.05
        return error

    def _pictures(
        self,
        found: PlanResult,
        film: Callable[[PlanResult], bytes | None],
        report: dict[str, Any],
    ) -> dict[str, bytes]:
        from kinolab.runs import FILM
        from kinolab.show.page.data import facts_told
        from kinolab.show.view import content_of, views

        animation = film(found)  # is begun before the page is made
        self._complete = animation is not None
        facts, (motion, earlier) = facts_told(report), self._shown
        if not (motion is found.trajectory and earlier == facts):
            content = content_of(self._problem, found.trajectory, report, found.graph)
            self._views, self._shown = views(content), (found.trajectory, facts)
        return self._views if animation is None else {**self._views, FILM: animation}

    def _add_film(self, animation: bytes) -> bool:
        from kinolab.files import write_whole
        from kinolab.runs import FILM, still_there

        with INTERRUPTS.writing(), still_there(self._folder, self.report) as there:
            if there:
                write_whole(self._folder / FILM, animation)
        return there
