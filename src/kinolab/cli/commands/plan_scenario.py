"""``plan SCENARIO``: search, verify, write, diagnose and render."""

from __future__ import annotations

import os
import sys
import webbrowser
from collections.abc import Iterator
from contextlib import ExitStack, redirect_stdout
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from kinolab.cli.common import (
    JOBS,
    NAMED,
    PATH,
    as_typed,
    film_process,
    quiet_option,
    replaced,
    set_option,
    unlogged,
)
from kinolab.cli.compile_ahead import compiled_ahead
from kinolab.cli.interrupts import EXIT_CODE as INTERRUPTED
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import echo_json, escaped, say
from kinolab.cli.versions import Versions
from kinolab.errors import InputError, Mistake

if TYPE_CHECKING:
    from kinolab.problem import PlanningTask
    from kinolab.search import Budget
    from kinolab.show.view.live_page import LivePage
    from kinolab.solve import PlanResult
    from kinolab.trajectory import Trajectory


@click.command("scenario", hidden=True)
@click.argument("scenario", type=NAMED)
@click.option("--planner", metavar="NAME", help="A planner's name, or file.py:Class.")
@click.option("--seed", type=click.IntRange(0), help="Seed of the random numbers.")
@click.option("--time-limit", type=float, metavar="SECONDS", help="Time limit of the search.")
@click.option("--max-iterations", type=click.IntRange(1), help="Iteration limit of the search.")
@click.option(
    "--roadmap",
    metavar="FILE",
    help="File in which the planner prm keeps its roadmap between runs.",
)
@click.option(
    "--jobs",
    type=JOBS,
    default=1,
    metavar="N",
    help="Run N searches at once, each with its own seed; the first plan wins.",
)
@click.option(
    "--anytime",
    is_flag=True,
    help="Keep planning until the time limit, and keep the shortest plan.",
)
@click.option(
    "--no-optimize",
    is_flag=True,
    help="Keep the first motion as it was found, without improving it.",
)
@click.option(
    "--guess",
    type=PATH,
    metavar="RUN",
    help="A run of this machine, whose motion is tried before anything is searched for.",
)
@set_option
@click.option("--out", type=PATH, help="Folder of the run; by default runs/<scenario>.")
@click.option("--json", "as_json", is_flag=True, help="Print the report as one JSON object.")
@click.option("--no-animation", is_flag=True, help="Write no pictures.")
@click.option("--no-diagnosis", is_flag=True, help="Do not diagnose why nothing was found.")
@click.option("--live", is_flag=True, help="Show in a browser how the search tree grows.")
@click.option("--no-browser", is_flag=True, help="With --live: only print the page's address.")
@quiet_option
def command(
    scenario: str,
    jobs: int,
    anytime: bool,
    no_optimize: bool,
    guess: Path | None,
    overrides: tuple[str, ...],
    out: Path | None,
    as_json: bool,
    no_animation: bool,
    no_diagnosis: bool,
    live: bool,
    no_browser: bool,
    quiet: bool,
    **keys: Any,
) -> int:
    """Plan a scenario."""
    from kinolab.api import load
    from kinolab.concurrency.processors import processors
    from kinolab.runs import PAGE, add_to_report, read_run, require_place, written_at
    from kinolab.runs.plan_summary import summary

    if live and jobs > 1:
        raise InputError([Mistake("--live", "a page shows one search.", "Leave --jobs out.")])

    progress = Progress(quiet)
    progress("deriving and compiling the machine")
    given = _overrides_of(scenario, keys)
    # User code prints none of the result, and notes of robots' files come in the summary.
    with as_typed(given), redirect_stdout(sys.stderr), unlogged():
        problem = load(scenario, overrides=[*overrides, *given])
    folder = out or Path("runs") / problem.name
    require_place(folder)
    earlier = written_at(folder)
    _warn(problem, folder, progress, quiet=quiet)
    with (
        compiled_ahead(),
        progress.compiling(),
        ExitStack() as opened,
    ):
        page, expected = (
            _live_page(problem, progress, opened, not no_browser) if live else (None, False)
        )
        film = None if no_animation else cache(lambda: opened.enter_context(film_process(progress)))
        # When one of several searches has a plan, the others end, unless more plans are wanted.
        versions = Versions(problem, folder, film, ahead=jobs < processors() or not anytime)
        with as_typed(given):
            found, complete = _search(
                problem, versions, progress, page,
                jobs=jobs, anytime=anytime, optimize=not no_optimize,
                guess=read_run(guess).trajectory if guess else None, quiet=quiet,
            )  # fmt: skip
        if not (found.status == "solved" or INTERRUPTS.seen or no_diagnosis):
            versions.report = _diagnose(problem, found, folder, versions.report, progress)
        report = versions.report

        def say_place() -> None:
            if as_json:
                echo_json({"folder": str(folder), **report})
            else:
                _say("  " + escaped(f"written to {folder}{replaced(earlier)}"))

        if page:
            page.verdict(found.status, found.message)
            finished = folder / PAGE
            page.end(finished.read_bytes() if finished.is_file() else None, expected=expected)
        progress.close()
        if not as_json:
            _say(summary(problem, found, report["diagnosis"].get("sentences", ())))
        bounds = _bound(problem, found, progress, quiet=as_json)
        # The command may be ended before the film is there.
        early = INTERRUPTS.seen and not complete
        if early:
            say_place()
        if not complete:
            progress("drawing the film")
        kept = complete or versions.wait_for_film()
    progress.close()
    report = add_to_report(folder, report, bounds) if bounds else report
    if not kept:
        progress(f"warning: another run was written into {folder} meanwhile.", lasting=True)
    if not early and (kept or as_json):
        say_place()
    return INTERRUPTED if INTERRUPTS.seen else found.exit_code


def _live_page(
    problem: PlanningTask, progress: Progress, opened: ExitStack, browser: bool
) -> tuple[LivePage, bool]:
    """Serve a page of the search until ``opened`` ends; say whether a browser was opened on it."""
    from kinolab.show.view.live_page import LivePage

    page = LivePage(problem, f"Searching for a plan: {problem.name}")
    opened.enter_context(page.served())
    opened.enter_context(progress.heard(page.say))
    progress(f"live on {page.address}", lasting=True)
    return page, browser and webbrowser.open(page.address)


def _warn(problem: PlanningTask, folder: Path, progress: Progress, *, quiet: bool) -> None:
    """Say what one should know before a search."""
    for note in problem.notes:
        progress(f"note: {note}", lasting=not quiet)
    for warning in _warnings(problem, folder):
        progress(f"warning: {warning}", lasting=True)


def _warnings(problem: PlanningTask, folder: Path) -> Iterator[str]:
    """Yield what one should know before a search, in sentences."""
    from kinolab.runs import replaced_scenario, warnings_before

    yield from warnings_before(problem)
    earlier = replaced_scenario(folder, problem)
    if earlier is not None:
        yield (
            f"{folder} has a run of {earlier}, which this one replaces. "
            "--out writes into another folder."
        )


def _say(text: str) -> None:
    """Print a text, unless the reader is gone: the files of the run are written all the same."""
    try:
        say(text)
    except BrokenPipeError:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115


def _overrides_of(scenario: str, keys: dict[str, Any]) -> dict[str, str]:
    """Return the overrides of [planner] that options stand for, each with its option."""
    from kinolab.scenario import scenario_path
    from kinolab.search.plugins import seen_from

    if keys["planner"]:  # a file is given relative to the working folder
        keys["planner"] = seen_from(scenario_path(scenario).parent, keys["planner"])
    return {
        f"planner.{'name' if key == 'planner' else key}={value}": f"--{key.replace('_', '-')}"
        for key, value in keys.items()
        if value is not None
    }


def _search(
    problem: PlanningTask,
    versions: Versions,
    progress: Progress,
    page: LivePage | None,
    *,
    jobs: int,
    anytime: bool,
    optimize: bool,
    guess: Trajectory | None,
    quiet: bool,
) -> tuple[PlanResult, bool]:
    """Search and write what was found; return it, and whether its film is written, too.

    While a plan is improved, there are earlier versions in the folder.
    """
    from kinolab.runs.plan_summary import progress_text
    from kinolab.scenario import improvement_seconds
    from kinolab.solve import solve

    section = problem.scenario.planner
    optimising = optimize and improvement_seconds(section.improve) > 0

    def report(iterations: int, elapsed: float) -> None:
        spent = f"{elapsed:.1f} of {section.time_limit:g} s"
        progress(f"{section.name}: {iterations} iterations, {spent}", passing=True)

    def say(text: str) -> None:
        progress(text, passing=True)

    def watch(budget: Budget) -> None:
        INTERRUPTS.ask(budget.end)
        budget.told = say
        if page:
            budget.viewer, budget.stage = page.explored, page.phase

    def improved(found: PlanResult) -> None:
        if page and found.trajectory is not None:
            page.found(found.trajectory)
            page.phase("optimise" if optimising else "search")
        if anytime or optimising:
            shown = versions.improved(found)
            if shown:
                what = "searching for shorter ones" if anytime else "improving it"
                text = f"{shown} shows the first motion; {what} (Ctrl-C keeps the best so far)"
                progress(text, lasting=not quiet)
            progress(progress_text(found, anytime=anytime))

    seeds = f"seed {section.seed}"
    if jobs > 1:
        seeds = f"seeds {section.seed} to {section.seed + jobs - 1}"
    progress(f"searching with {section.name}, {seeds}")
    with (
        INTERRUPTS.asking(),
        INTERRUPTS.sharing_fate(jobs > 1),
        redirect_stdout(sys.stderr),
    ):
        found = solve(
            problem,
            jobs=jobs,
            anytime=anytime,
            optimize=optimize,
            guess=guess,
            contained=INTERRUPTS.after_crash,
            progress=report,
            watch=watch,
            improved=improved,
        )
        if found.interrupted and not found.iterations:
            raise KeyboardInterrupt  # nothing was found; an earlier run in the folder stays
        progress("verified" if found.certificate else found.message)
        for attempt in found.attempts:
            if attempt.status == "failed":
                progress(f"warning: seed {attempt.seed}: {attempt.detail}")
        if found.trajectory is not None and versions.pictured:
            progress("drawing the page")
            if page:
                page.phase("draw")
        return found, versions.end(found)


def _diagnose(
    problem: PlanningTask,
    found: PlanResult,
    folder: Path,
    report: dict[str, Any],
    progress: Progress,
) -> dict[str, Any]:
    """Diagnose why no plan was found; return the report with the diagnosis."""
    from kinolab.analyze.diagnose import diagnose
    from kinolab.runs import add_to_report

    with redirect_stdout(sys.stderr):  # keep output of user planners out of the result
        diagnosis = diagnose(problem, found, progress=progress)
    INTERRUPTS.raise_if_seen()
    with INTERRUPTS.writing():
        whole = {**report["diagnosis"], **diagnosis.to_json()}
        return add_to_report(folder, report, {"diagnosis": whole})


def _bound(
    problem: PlanningTask, found: PlanResult, progress: Progress, *, quiet: bool
) -> dict[str, Any]:
    """Prove how long every plan takes at least, and say so; return what the report says of it."""
    if found.status != "solved" or found.trajectory is None or INTERRUPTS.seen:
        return {}
    from kinolab.verification.lower_bound import duration_bound

    progress("proving how long every plan takes at least")
    bound = duration_bound(problem)
    progress.close()
    if not quiet:
        _say(f"  {bound.sentence(found.trajectory.duration)}")
    return {"duration_bound": asdict(bound)}
