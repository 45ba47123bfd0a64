"""``plan plot``: plot a finished run for a report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from kinolab.cli.common import PATH, quiet_option
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import escaped, say


@click.command("plot")
@click.argument("folder", type=PATH)
@click.option(
    "--format", "form", type=click.Choice(["svg", "png"]), default="svg", show_default=True
)
@click.option("--plane", metavar="A,B", help="Coordinates of the configuration plane.")
@quiet_option
def command(folder: Path, form: Any, plane: str | None, quiet: bool) -> int:
    """Plot states and inputs over time, phase portraits and a plane of the configuration space.

    The plots go to plots/ in the folder of the run.
    """
    from kinolab.errors import InputError, Mistake
    from kinolab.files import write_whole
    from kinolab.runs import read_run
    from kinolab.show.plots import plots

    names = None if plane is None else tuple(name.strip() for name in plane.split(","))
    if names is not None and (len(names) != 2 or names[0] == names[1]):
        raise InputError([Mistake("--plane", f"{plane!r} is no pair.", "Write it as x,y.")])
    progress = Progress(quiet)
    progress("reading the run and compiling the machine")
    run = read_run(folder)
    progress("plotting")
    made = plots(run.problem, run.trajectory, run.graph, form=form, plane=names)
    progress.close()
    with INTERRUPTS.writing():
        (folder / "plots").mkdir(exist_ok=True)
        for name, content in made.items():
            write_whole(folder / "plots" / name, content)
    for name in made:
        say(escaped(str(folder / "plots" / name)))
    return 0
