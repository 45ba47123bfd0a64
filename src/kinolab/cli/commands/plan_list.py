"""``plan list``: list scenarios, systems, and planners with their settings."""

from __future__ import annotations

import sys
from contextlib import redirect_stdout

import click

from kinolab.cli.common import json_option
from kinolab.cli.terminal import echo_json, say


@click.command("list")
@click.argument(
    "group", type=click.Choice(["scenarios", "systems", "planners", "options"]), required=False
)
@click.argument("names", nargs=-1)
@json_option
def command(group: str | None, names: tuple[str, ...], as_json: bool) -> int:
    """Name the scenarios, systems and planners.

    `plan list planners` shows the settings of every planner, `plan list planners NAME` those of
    one; NAME may be file.py:Class. `plan list options` shows all numbers of the optimiser.
    """
    from kinolab.cli.listing import listed, listed_as_text

    with redirect_stdout(sys.stderr):  # keep output of planner files out of the result
        found = listed(group, names) if as_json else listed_as_text(group, names)
    echo_json(found) if as_json else say(str(found))
    return 0
