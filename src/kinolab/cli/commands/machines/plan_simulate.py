"""``plan simulate``: simulate a machine unforced, or under inputs from a file."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import click

from kinolab.cli.common import (
    NAMED,
    PATH,
    as_typed,
    film_process,
    quiet_option,
    replaced,
    set_option,
)
from kinolab.cli.interrupts import EXIT_CODE as INTERRUPTED
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import say
from kinolab.cli.versions import Versions


@click.command("simulate")
@click.argument("what", type=NAMED)
@click.option("--duration", type=float, default=5.0, show_default=True, metavar="SECONDS")
@click.option("--start", multiple=True, metavar="NAME=VALUE", help="A state at the beginning.")
@click.option("--inputs", type=PATH, help="CSV with t and inputs; default: none act.")
@set_option
@click.option("--out", type=PATH, help="Folder; default runs/<name>.")
@click.option("--no-animation", is_flag=True, help="Leave all pictures out.")
@quiet_option
def command(
    what: str,
    duration: float,
    start: tuple[str, ...],
    inputs: Path | None,
    overrides: tuple[str, ...],
    out: Path | None,
    no_animation: bool,
    quiet: bool,
) -> int:
    """Let WHAT move by itself: a system, a scenario, or machine.py:function.

    Obstacles do not stop it.
    """
    from kinolab.analyze.simulate import drifting_constraints, simulate
    from kinolab.loading import build_problem, find_scenario
    from kinolab.runs import written_at
    from kinolab.solve import PlanResult

    progress = Progress(quiet)
    progress("deriving and compiling the machine")
    given = [*overrides, *(f"start.{entry}" for entry in start)]
    with as_typed({f"start.{entry}": f"--start {entry}" for entry in start}):
        problem = build_problem(find_scenario(what, overrides=given), planning=False)
    trajectory = simulate(problem, duration, inputs)
    distance = problem.goal_distance(trajectory.x[-1])
    moved = PlanResult(
        "simulated", trajectory, None, "none", 0, 0, distance, message="Moved by itself."
    )
    folder = out or Path("runs") / f"{problem.name}_simulated"
    earlier = written_at(folder)
    with ExitStack() as opened:
        film = None if no_animation else opened.enter_context(film_process(progress))
        if film:
            progress("drawing the pictures")
            opened.enter_context(progress.compiling())
        versions = Versions(problem, folder, (lambda: film) if film else None)
        if not versions.end(moved):
            versions.wait_for_film()
    progress.close()
    place = f"{folder}{replaced(earlier)}"
    say(f"simulated: {trajectory.duration:g} s\n  written to {place}")
    for sentence in drifting_constraints(problem, trajectory):
        say(f"warning: {sentence}", err=True)
    return INTERRUPTED if INTERRUPTS.seen else moved.exit_code
