"""``plan warm-up``: compile all inner loops ahead of time."""

from __future__ import annotations

import time

import click

from kinolab.cli.common import JOBS, quiet_option
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import say


@click.command("warm-up")
@click.option(
    "--jobs",
    type=JOBS,
    metavar="N",
    help="Processes at most; default: as many as there are processors.",
)
@quiet_option
def command(jobs: int | None, quiet: bool) -> int:
    """Compile all inner loops now, so that no plan has to wait for it.

    It is done once on a computer, and again after an update of kinolab, numba or Python.
    """
    from kinolab.cli.warm_up_processes import warm_up
    from kinolab.numerics.compiling import running

    progress, begun, functions = Progress(quiet), time.monotonic(), 0
    progress("looking for what is not compiled yet")

    def told(so_far: int) -> None:
        progress(running(so_far, time.monotonic() - begun), passing=True)

    for part in warm_up(jobs=jobs, progress=told):
        progress.close()
        functions += part.functions
        made = f"{part.functions} functions in {part.seconds:.1f} s"
        say(f"{part.part}: {made if part.functions else 'nothing to compile'}")
    taken = f"{functions} functions in {time.monotonic() - begun:.1f} s"
    say(f"compiled {taken}" if functions else "everything was compiled before")
    return 0
