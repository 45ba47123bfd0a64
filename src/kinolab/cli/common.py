"""Shared by commands: options, an exit code, JSON output, pictures."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from kinolab.problem import PlanningTask
    from kinolab.solve import PlanResult

FAILED = 7  # exit code: a motion or a machine failed its checks
MAX_JOBS = 256  # processes; each of them loads every library
PATH: click.Path = click.Path(path_type=Path)

json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
quiet_option = click.option("--quiet", is_flag=True, help="No progress on stderr.")
set_option = click.option(
    "--set", "overrides", multiple=True, metavar="KEY=VALUE", help="Any scenario key."
)


def echo_json(data: Any) -> None:
    """Print plain data as JSON on one line."""
    click.echo(json.dumps(data, ensure_ascii=False))


def write_pictures(
    problem: PlanningTask, found: PlanResult, folder: Path, report: dict[str, Any]
) -> None:
    """Write the animation, the page and the scene of a motion."""
    from kinolab.files import write_whole
    from kinolab.show.film.animation import animate
    from kinolab.show.view import write_scene

    assert found.trajectory is not None
    write_whole(folder / "animation.gif", animate(problem, found.trajectory))
    write_scene(folder, problem, found.trajectory, report, found.graph)
