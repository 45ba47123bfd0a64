"""``plan execute``: execute a plan on perturbed machines in closed loop."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from kinolab.cli.common import PATH, SHARE, json_option, large_option, quiet_option
from kinolab.cli.engines import dask_option, engine_of, jobs_option
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import echo_json, escaped, say


@click.command("execute")
@click.argument("folder", type=PATH)
@click.option(
    "--parameters",
    **SHARE,
    help="Vary each parameter by up to this share of its value, but for the "
    "strength of gravity and what the machine lists as keep.",
)
@click.option(
    "--vary",
    "varied",
    metavar="NAME=SHARE,…",
    multiple=True,
    help="Vary these parameters, each by its own share: m=0.1,mu=0.2.",
)
@click.option(
    "--keep", metavar="NAME,…", multiple=True, help="Parameters that --parameters leaves alone."
)
@click.option(
    "--track",
    metavar="NAME,…",
    multiple=True,
    help="Track coordinates on which nothing depends, such as how far a wheel has rolled.",
)
@click.option("--noise", **SHARE, help="Measurement noise, as a share of each state's scale.")
@click.option("--disturbance", **SHARE, help="Disturbance of each input, as a share of its range.")
@click.option(
    "--set",
    "built",
    metavar="NAME=VALUE",
    multiple=True,
    help="The real machine's value of a parameter; may be repeated.",
)
@large_option
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
@click.option("--no-diagnosis", is_flag=True, help="Do not look for what makes runs fail.")
@quiet_option
def command(
    folder: Path,
    parameters: float,
    noise: float,
    disturbance: float,
    varied: tuple[str, ...],
    keep: tuple[str, ...],
    track: tuple[str, ...],
    built: tuple[str, ...],
    large: float,
    untracked: bool,
    runs: int,
    seed: int,
    jobs: int | None,
    dask: str | None,
    as_json: bool,
    no_picture: bool,
    no_diagnosis: bool,
    quiet: bool,
) -> int:
    """Execute the plan of a finished run many times in closed loop, and say what fails, and why.

    Each simulated machine differs from the one that the plan was made for. Feedback gains along the
    plan keep it on course, together with the machine's own feedback if it has any; both are
    designed for the plan's parameters. The results are written to execution.json, execution.csv
    and execution.png in FOLDER. They are the same however many do the work;
    up to 500 runs are done by one process, unless --jobs says otherwise.
    """
    from kinolab.analyze.execute.conditions import Conditions
    from kinolab.analyze.execute.execution import Executor
    from kinolab.analyze.execute.execution_diagnosis import diagnose_execution
    from kinolab.analyze.execute.execution_report import execution_to_json, summary_lines
    from kinolab.analyze.execute.tube_plot import tube_png
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
    conditions = Conditions(
        parameters,
        noise,
        disturbance,
        built=values,
        tracked=not untracked,
        vary=_shares(varied),
        keep=_names(keep),
        track=_names(track),
    )
    progress("reading the run and compiling the machine")
    run = read_run(folder)

    def told(made: int) -> None:
        progress(f"executing the plan, {made} of {runs} runs done", passing=True)

    with engine_of(jobs, dask, progress) as (make, stop):
        execution = execute_many(
            run,
            conditions,
            # 500 runs for which it is not worth to start other processes
            make if dask or jobs or runs > 500 else None,
            runs=runs,
            seed=seed,
            large=large,
            table=folder / TABLE,
            told=told,
            stop=stop,
        )
    found = None
    if execution.failures and not no_diagnosis:
        executor = Executor(run.problem, run.trajectory, conditions, seed=seed, large=large)
        found = diagnose_execution(executor, execution, say=progress)
    progress.close()
    report = execution_to_json(run.problem, execution, found)
    with INTERRUPTS.writing():
        write_whole(folder / "execution.json", (json.dumps(report, indent=1) + "\n").encode())
        if not no_picture:
            name = printable(str(run.report.get("scenario", folder.name)))
            picture = tube_png(run.problem, run.trajectory, execution, shortened(name))
            write_whole(folder / "execution.png", picture)
    if as_json:
        echo_json(report)
        return 0
    first, *rest = summary_lines(run.problem, execution, found)
    say(escaped(f"{folder}: {first}"))
    if run.report.get("status") not in ("solved", "simulated"):
        why = printable(str(run.report.get("message", "")))
        say(f"  the plan itself does not reach the goal: {why}")
    for line in rest:
        say(escaped(line))
    return 0


def _names(texts: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names in lists that are separated by commas."""
    return tuple(name.strip() for text in texts for name in text.split(",") if name.strip())


def _shares(texts: tuple[str, ...]) -> dict[str, float]:
    """Return the shares that were typed, by name.

    Raises:
        InputError: If one has no number.
    """
    from kinolab.errors import InputError, Mistake

    shares, mistakes = {}, []
    for entry in _names(texts):
        name, _, number = entry.partition("=")
        try:
            shares[name.strip()] = float(number)
        except ValueError:
            what = f"{entry!r} is no name with a share."
            mistakes.append(Mistake("--vary", what, "Write it as m=0.1, several with commas."))
    if mistakes:
        raise InputError(mistakes)
    return shares
