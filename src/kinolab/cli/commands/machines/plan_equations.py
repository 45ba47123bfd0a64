"""``plan equations``: print the equations of motion of a machine."""

from __future__ import annotations

import click

from kinolab.cli.common import NAMED, quiet_option
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import say


@click.command("equations")
@click.argument("what", type=NAMED)
@click.option("--latex", is_flag=True, help="Print LaTeX.")
@quiet_option
def command(what: str, latex: bool, quiet: bool) -> int:
    """Print the equations of motion of WHAT: a system, a scenario, or machine.py:function."""
    from kinolab.analyze.describe.each_mode import in_each_mode
    from kinolab.loading import find_machine

    progress = Progress(quiet)
    progress(f"reading {what}")
    for title, machine in in_each_mode(find_machine(what)):
        progress(f"deriving equations of motion of {len(machine.coordinates)} coordinates")
        equations = machine.equations()
        progress.close()
        if title:
            say(title)
        say(equations.latex() if latex else equations.text())
    return 0
