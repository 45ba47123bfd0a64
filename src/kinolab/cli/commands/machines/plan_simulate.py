"""``plan simulate``: simulate a machine unforced, or under inputs from a file."""

from __future__ import annotations

from pathlib import Path

import click

from kinolab.cli.common import (
    PATH,
    as_typed,
    film_process,
    quiet_option,
    replaced,
    set_option,
    write_pictures,
)
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import say


@click.command("simulate")
@click.argument("what")
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
    from kinolab.runs import write_run, written_at
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
    with INTERRUPTS.writing():
        report = write_run(folder, problem, moved)
    if not no_animation:
        progress("drawing the pictures")
        with progress.compiling(), film_process(progress) as film:
            write_pictures(problem, moved, folder, report, film, lambda: None)
    progress.close()
    place = f"{folder}{replaced(earlier)}"
    say(f"simulated: {trajectory.duration:g} s\n  written to {place}")
    for sentence in drifting_constraints(problem, trajectory):
        say(f"warning: {sentence}", err=True)
    return moved.exit_code
