"""``plan view``: show a finished run, or a scenario before planning, in the browser."""

from __future__ import annotations

import sys
import tempfile
import webbrowser
from collections.abc import Sequence
from contextlib import redirect_stdout
from pathlib import Path

import click

from kinolab.cli.common import PATH, quiet_option, set_option
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress
from kinolab.errors import EndpointError, InputError, Mistake


@click.command("view")
@click.argument("what")
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
    """Open the interactive page of WHAT: the folder of a run, or a scenario before planning.

    A run's page is scene.html in its folder, and is made anew where it is missing. A scenario is
    shown with its world, start and goal, to be checked by eye; its page goes to --out, or else to
    a new folder for temporary files.
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
    click.echo(str(page))
    if not no_browser:
        address = page.resolve().as_uri() + ("" if at is None else f"#t={at:g}")
        if not webbrowser.open(address):
            print(f"no browser could be started; open {address}", file=sys.stderr)
    return 0


def _page_of_run(folder: Path, progress: Progress) -> Path:
    from kinolab.runs import PAGE

    page = folder / PAGE
    if not page.is_file():
        from kinolab.runs import read_run
        from kinolab.show.view import write_scene

        progress("drawing the page")
        run = read_run(folder)
        with INTERRUPTS.writing():
            write_scene(folder, run.problem, run.trajectory, run.report, run.graph)
    return page


def _page_of_scenario(
    what: str, overrides: Sequence[str], out: Path | None, progress: Progress
) -> Path:
    from kinolab.loading import load
    from kinolab.show.view import save_page

    progress("deriving and compiling the machine")
    with redirect_stdout(sys.stderr):  # keep output of user code out of the result
        problem = load(what, overrides=list(overrides))
    page = out or Path(tempfile.mkdtemp(prefix="kinolab-")) / f"{problem.name}.html"
    written = save_page(problem, None, page)
    try:
        problem.check_endpoints()
    except EndpointError as error:  # shown all the same: one sees best there what is wrong
        progress.close()
        print(error, file=sys.stderr)
    return written
