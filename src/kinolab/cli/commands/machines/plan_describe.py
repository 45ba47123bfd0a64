"""``plan describe``: structure and controllability of a machine."""

from __future__ import annotations

import sys
from contextlib import redirect_stdout

import click

from kinolab.cli.common import NAMED, json_option, quiet_option, unlogged
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import echo_json, say


@click.command("describe")
@click.argument("what", type=NAMED)
@json_option
@quiet_option
def command(what: str, as_json: bool, quiet: bool) -> int:
    """Say what WHAT is and whether it can be controlled."""
    from kinolab.analyze.describe.data import description_to_json
    from kinolab.analyze.describe.description import describe
    from kinolab.analyze.describe.description_text import described_as_text
    from kinolab.analyze.describe.each_mode import in_each_mode
    from kinolab.loading import find_machine

    progress = Progress(quiet)
    progress(f"reading {what}")
    with redirect_stdout(sys.stderr), unlogged():  # keep output of user code out of the result
        machine = find_machine(what)
        progress(f"looking at its {len(machine.coordinates)} coordinates")
        switching = [transition.name for transition in machine.transitions]
        found = [
            (title, describe(one, switching=switching)) for title, one in in_each_mode(machine)
        ]
    progress.close()
    if as_json:
        documents = [description_to_json(description) for _, description in found]
        echo_json(documents[0] if len(documents) == 1 else {"modes": documents})
        return 0
    for title, description in found:
        if title:
            say(title)
        say(described_as_text(description))
    return 0
