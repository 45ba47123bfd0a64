"""``plan execute``: execute a plan on perturbed machines in closed loop."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from kinolab.cli.common import PATH, json_option, quiet_option
from kinolab.cli.engines import dask_option, engine_of, jobs_option
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import echo_json, escaped, say

FEW = 500  # runs for which it is not worth to start other processes
SHARE: dict[str, Any] = {"type": float, "metavar": "SHARE", "default": 0.0, "show_default": True}


@click.command("execute")
@click.argument("folder", type=PATH)
@click.option("--parameters", **SHARE, help="Vary each parameter by up to this share of its value.")
@click.option("--noise", **SHARE, help="Measurement noise, as a share of each state's scale.")
@click.option("--disturbance", **SHARE, help="Disturbance of each input, as a share of its range.")
@click.option(
    "--set",
    "built",
    metavar="NAME=VALUE",
    multiple=True,
    help="The real machine's value of a parameter; may be repeated.",
)
@click.option(
    "--large",
    type=click.FloatRange(0.0, 1.0, min_open=True),
    metavar="SHARE",
    default=0.2,
    show_default=True,
    help="Deviation that the gains answer strongly, as a share of one over each state's weight in "
    "[metric]; smaller is stiffer.",
)
@click.option("--untracked", is_flag=True, help="Leave out the feedback gains along the plan.")
@click.option(
    "--runs",
    type=click.IntRange(1, 10_000_000),
    default=100,
    show_default=True,
    help="How many times.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=1,
    show_default=True,
    help="Seed of the random numbers.",
)
@jobs_option
@dask_option
@json_option
@click.option("--no-picture", is_flag=True, help="Leave execution.png out.")
@quiet_option
def command(
    folder: Path,
    parameters: float,
    noise: float,
    disturbance: float,
    built: tuple[str, ...],
    large: float,
    untracked: bool,
    runs: int,
    seed: int,
    jobs: int | None,
    dask: str | None,
    as_json: bool,
    no_picture: bool,
    quiet: bool,
) -> int:
    """Execute the plan of a finished run many times in closed loop, and count the outcomes.

    Each simulated machine differs from the one that the plan was made for. Feedback gains along the
    plan keep it on course, together with the machine's own feedback if it has any; both are
    designed for the plan's parameters. The results are written to execution.json, execution.csv
    and execution.png in FOLDER. They are the same however many do the work;
    up to 500 runs are done by one process, unless --jobs says otherwise.
    """
    from kinolab.analyze.execute.conditions import Conditions
    from kinolab.analyze.execute.tube_plot import execution_to_json, tube_png
    from kinolab.errors import InputError, printable
    from kinolab.files import write_whole
    from kinolab.runs import read_run
    from kinolab.scenario.overrides import apply_overrides
    from kinolab.scenario.toml_text import shortened
    from kinolab.studies.executions import TABLE, execute_many

    progress = Progress(quiet)
    values: dict[str, Any] = {}
    if mistakes := apply_overrides(values, built)[1]:  # the machine itself validates the values
        raise InputError(mistakes)
    conditions = Conditions(parameters, noise, disturbance, values, not untracked)
    progress("reading the run and compiling the machine")
    run = read_run(folder)

    def told(made: int) -> None:
        progress(f"carried out {made} of {runs} times", passing=True)

    with engine_of(jobs, dask, progress) as (make, stop):
        execution = execute_many(
            run,
            conditions,
            make if dask or jobs or runs > FEW else None,
            runs=runs,
            seed=seed,
            large=large,
            table=folder / TABLE,
            told=told,
            stop=stop,
        )
    progress.close()
    report = execution_to_json(execution)
    with INTERRUPTS.writing():
        write_whole(folder / "execution.json", (json.dumps(report, indent=1) + "\n").encode())
        if not no_picture:
            name = printable(str(run.report.get("scenario", folder.name)))
            picture = tube_png(run.problem, run.trajectory, execution, shortened(name))
            write_whole(folder / "execution.png", picture)
    if as_json:
        echo_json(report)
        return 0
    counts = ", ".join(f"{count} {outcome}" for outcome, count in sorted(report["counts"].items()))
    say(escaped(f"{folder}: {execution.reached} of {runs} reached the goal ({counts})"))
    say(f"  largest deviation from the plan: {execution.worst:.3g}, weighted")
    if run.report.get("status") not in ("solved", "simulated"):
        why = printable(str(run.report.get("message", "")))
        say(f"  the plan itself does not reach the goal: {why}")
    return 0
