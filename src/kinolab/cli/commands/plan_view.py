"""``plan view``: show a finished run, a scenario before planning, or a machine, in the browser."""

from __future__ import annotations

import sys
import tempfile
import webbrowser
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from kinolab.cli.common import NAMED, PATH, quiet_option, set_option
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import escaped, say
from kinolab.errors import EndpointError, InputError, Mistake
from kinolab.files import is_file_with, utf_8, write_whole

if TYPE_CHECKING:
    from kinolab.problem import PlanningTask


@click.command("view")
@click.argument("what", type=NAMED)
@click.option("--at", type=float, metavar="SECONDS", help="Open at this time of the motion.")
@click.option("--out", type=PATH, help="File of a scenario's page.")
@set_option
@click.option("--no-browser", is_flag=True, help="Only write the page, and print where it is.")
@quiet_option
def command(
    what: str,
    at: float | None,
    out: Path | None,
    overrides: tuple[str, ...],
    no_browser: bool,
    quiet: bool,
) -> int:
    """Open the interactive page of WHAT: the folder of a run, a scenario, or a machine.

    A run's page is drawn from its files. It is scene.html in its folder, unless the one there is
    another, which anybody may have written: then it goes to a new folder for temporary files. A
    scenario is shown with its world, start and goal, to be checked by eye; a machine, given by its
    name or as machine.py:function, is shown by itself. Both can be moved by sliders, one for each
    coordinate. The page goes to --out, or else to a new folder for temporary files.
    """
    progress = Progress(quiet)
    folder = Path(what)
    if folder.is_dir():
        if out is not None or overrides:
            remedy = "They are for scenarios; a run is shown as it is."
            raise InputError([Mistake("--out, --set", f"{what} is a finished run.", remedy)])
        page = _page_of_run(folder, progress)
    else:
        page = _page_of_scenario(what, overrides, out, progress)
    progress.close()
    say(escaped(str(page)))
    if not no_browser:
        address = page.resolve().as_uri() + ("" if at is None else f"#t={at:g}")
        if not webbrowser.open(address):
            say(f"no browser could be started; open {address}", err=True)
    return 0


def _page_of_run(folder: Path, progress: Progress) -> Path:
    """Return the page that is drawn from a run's files; a browser runs no other."""
    from kinolab.runs import PAGE, read_run
    from kinolab.show.page import page_html
    from kinolab.show.view import content_of, write_model

    progress("drawing the page")
    run = read_run(folder)
    content = content_of(run.problem, run.trajectory, run.report, run.graph)
    drawn, page = utf_8(page_html(content)), folder / PAGE
    if is_file_with(page, drawn):
        return page
    if page.exists():
        page = Path(tempfile.mkdtemp(prefix="kinolab-")) / PAGE
        progress.close()
        told = f"{folder / PAGE} is not what the run's files give; they are drawn anew."
        say(escaped(told), err=True)
    with INTERRUPTS.writing():
        write_whole(page, drawn)
        if page.parent == folder:
            write_model(folder, content)
    return page


def _page_of_scenario(
    what: str, overrides: Sequence[str], out: Path | None, progress: Progress
) -> Path:
    from kinolab.loading import load, names_scenario
    from kinolab.show.view import save_page

    progress("deriving and compiling the machine")
    with redirect_stdout(sys.stderr):  # keep output of user code out of the result
        named = names_scenario(what)
        problem = load(what, overrides=overrides) if named else _alone(what, overrides)
    page = out or Path(tempfile.mkdtemp(prefix="kinolab-")) / f"{problem.name}.html"
    written = save_page(problem, None, page)
    try:
        if problem.asks:
            problem.check_endpoints()
    except EndpointError as error:  # shown all the same: one sees best there what is wrong
        progress.close()
        say(str(error), err=True)
    return written


def _alone(what: str, overrides: Sequence[str]) -> PlanningTask:
    """Return the problem of a machine by itself, on the ground if one of its bodies touches it."""
    from kinolab.loading import build_problem, find_scenario

    problem = build_problem(find_scenario(what, overrides=overrides), planning=False)
    grounded = any(body.touches_ground for body in problem.bodies)
    return replace(problem, world=replace(problem.world, ground=grounded or problem.world.ground))
