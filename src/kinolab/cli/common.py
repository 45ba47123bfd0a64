"""Shared by commands: options, an exit code, words about runs, films."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.shell_completion import CompletionItem

from kinolab.errors import InputError

if TYPE_CHECKING:
    from kinolab.cli.progress import Progress
    from kinolab.show.film.film_process import FilmProcess

FAILED = 7  # exit code: a motion or a machine failed its checks
JOBS = click.IntRange(1, 256)  # processes; each of them loads every library
PATH: click.Path = click.Path(path_type=Path)


def scenarios_and_files(incomplete: str) -> list[CompletionItem]:
    """Return scenarios and systems whose names begin so, and let a shell add its files."""
    from kinolab import systems
    from kinolab.scenario import builtin_scenarios

    known = dict.fromkeys([*builtin_scenarios(), *systems.names()])
    found = [CompletionItem(name) for name in known if name.startswith(incomplete)]
    return [*found, CompletionItem(incomplete, type="file")]


class _Named(click.ParamType[str]):
    """A text that names a scenario, a system or a file."""

    name = "text"

    def shell_complete(
        self, _context: click.Context, _parameter: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Complete it as ``scenarios_and_files``."""
        return scenarios_and_files(incomplete)


NAMED = _Named()

json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
quiet_option = click.option("--quiet", is_flag=True, help="Print no progress on stderr.")
# What options have that say by how much something may be off.
SHARE: dict[str, Any] = {"type": float, "metavar": "SHARE", "default": 0.0, "show_default": True}
large_option = click.option(
    "--large",
    type=click.FloatRange(0.0, 1.0, min_open=True),
    metavar="SHARE",
    default=0.2,
    show_default=True,
    help="Deviation that the gains answer strongly, as a share of one over each state's weight in "
    "[metric]; smaller is stiffer.",
)
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
