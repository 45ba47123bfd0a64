"""``plan prove``: prove that every machine within some bounds carries a plan out."""

from __future__ import annotations

from pathlib import Path

import click

from kinolab.cli.common import FAILED, PATH, SHARE, json_option, large_option, quiet_option
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import echo_json, escaped, say


@click.command("prove")
@click.argument("folder", type=PATH)
@click.option(
    "--percent",
    type=click.FloatRange(0.0, 100.0, max_open=True),
    default=5.0,
    show_default=True,
    help="By how many percent of its value each parameter may be off.",
)
@click.option(
    "--parameters",
    metavar="NAME,…",
    multiple=True,
    help="Which parameters are uncertain; all but the strength of gravity, what the machine lists "
    "as keep, and what the size of a shape depends on, when left out.",
)
@click.option(
    "--noise",
    **SHARE,
    help="By how much a measurement is off at most, as a share of the state's scale.",
)
@click.option(
    "--disturbance",
    **SHARE,
    help="By how much an input is off at most, in every step anew, as a share of its range.",
)
@large_option
@json_option
@quiet_option
def command(
    folder: Path,
    percent: float,
    parameters: tuple[str, ...],
    noise: float,
    disturbance: float,
    large: float,
    as_json: bool,
    quiet: bool,
) -> int:
    """Prove that every machine within some bounds carries the plan of a finished run out.

    A tube is computed that contains the motions of all such machines, with the feedback gains of
    plan execute. If nothing is touched in it, no limit is passed and it ends in the goal, that is
    proved of all of them; if not, the largest share of the uncertainty is looked for under which it
    is. The result is written to tube.json in FOLDER; plan check proves it again. The exit code is 7
    where what was asked for is not proved.
    """
    from kinolab.runs import read_run
    from kinolab.runs.tube_file import write_tube
    from kinolab.verification.tube.claim import claimed
    from kinolab.verification.tube.proof import Prover
    from kinolab.verification.tube.uncertainty import (
        Uncertainty,
        kept_by_default,
        varied_by_default,
    )

    progress = Progress(quiet)
    progress("reading the run and enclosing its motion")
    run = read_run(folder)
    named = [name.strip() for text in parameters for name in text.split(",") if name.strip()]
    varied = named or varied_by_default(run.problem, kept_by_default(run.problem.system))
    asked = Uncertainty(dict.fromkeys(varied, percent / 100.0), noise, disturbance)
    asked.require(run.problem)
    prover = Prover(run.problem, run.trajectory, large=large)
    claim = claimed(prover, asked)
    progress.close()
    with INTERRUPTS.writing():
        data = write_tube(folder, claim)
    if as_json:
        echo_json(data)
    else:
        verdict, *rest = claim.lines()
        say(escaped(f"{folder}: {verdict}"))
        for line in rest:
            say(escaped(line))
    return 0 if claim.proved else FAILED
