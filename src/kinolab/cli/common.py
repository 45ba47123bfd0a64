"""Shared by commands: options, an exit code, pictures."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from kinolab.errors import InputError

if TYPE_CHECKING:
    from kinolab.cli.progress import Progress
    from kinolab.problem import PlanningTask
    from kinolab.show.film.film_process import FilmProcess
    from kinolab.solve import PlanResult

FAILED = 7  # exit code: a motion or a machine failed its checks
MAX_JOBS = 256  # processes; each of them loads every library
PATH: click.Path = click.Path(path_type=Path)

json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
quiet_option = click.option("--quiet", is_flag=True, help="Print no progress on stderr.")
set_option = click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change any key of the scenario; may be repeated.",
)


@contextmanager
def as_typed(options: Mapping[str, str]) -> Iterator[None]:
    """Report mistakes in overrides under the options that stand for them.

    Args:
        options: As they were typed, by override.
    """
    from kinolab.scenario import override_place

    try:
        yield
    except InputError as error:
        typed = {override_place(override): option for override, option in options.items()}
        mistakes = (replace(m, where=typed.get(m.where, m.where)) for m in error.mistakes)
        raise InputError(mistakes) from None


@contextmanager
def unlogged() -> Iterator[None]:
    """Leave to a command itself what readers of robots' files would log."""
    log = logging.getLogger("kinolab.robots")
    log.disabled = True
    try:
        yield
    finally:
        log.disabled = False


def replaced(earlier: datetime | None) -> str:
    """Return what is added to the place of a run: of when the one was that had been there."""
    if earlier is None:
        return ""
    today = earlier.date() == datetime.now().astimezone().date()
    return f", replacing the run of {earlier:{'%H:%M' if today else '%Y-%m-%d %H:%M'}}"


def film_process(progress: Progress) -> FilmProcess:
    """Return the process, to be entered, that will draw the film of a plan."""
    from kinolab.show.film.film_process import FilmProcess

    return FilmProcess(lambda text: progress(text, passing=True))


def write_pictures(
    problem: PlanningTask,
    found: PlanResult,
    folder: Path,
    report: dict[str, Any],
    film: FilmProcess,
    page_written: Callable[[], None],
) -> bool:
    """Write the page of a motion, then the scene for Blender and the animation.

    They are not written if another run was written into the folder meanwhile.

    Args:
        problem: The machine in its world.
        found: The motion.
        folder: Of the run.
        report: Of the run.
        film: The process that draws the animation.
        page_written: Called as soon as the page is there.

    Returns:
        Whether the folder still has this run.
    """
    from kinolab.files import write_whole
    from kinolab.runs import still_there
    from kinolab.show.view import content_of, write_model, write_page

    assert found.trajectory is not None
    film.begin(problem, found.trajectory)
    content = content_of(problem, found.trajectory, report, found.graph)
    with still_there(folder, report) as there:
        if there:
            write_page(folder, content)
            write_model(folder, content)
    page_written()
    animation = film.animation()
    with still_there(folder, report) as there:
        if there:
            write_whole(folder / "animation.gif", animation)
    return there
