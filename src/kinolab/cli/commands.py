"""The command line: ``plan SCENARIO`` and its sisters. Every import beyond click comes late."""

from __future__ import annotations

import json
import os
import sys
import time
import traceback
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from kinolab.cli.execute import execute_plan
from kinolab.cli.gallery import write_gallery
from kinolab.cli.interrupts import EXIT_CODE as INTERRUPTED
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.live import Spectators, spectators
from kinolab.cli.plot import plot
from kinolab.cli.progress import Progress, escaped
from kinolab.cli.video import write_video
from kinolab.cli.view import view
from kinolab.errors import InputError, KinolabError, Mistake

if TYPE_CHECKING:
    from kinolab.problem import Problem
    from kinolab.search import Budget
    from kinolab.solve import Plan

USAGE, RESOURCES, FAILED, INTERNAL = 2, 6, 7, 70
MAX_JOBS = 256  # processes; each of them loads every library


class _Front(click.Group):
    """A group whose first argument may be a scenario instead of a command."""

    def parse_args(self, context: click.Context, args: list[str]) -> list[str]:
        if args and args[0] not in (*self.commands, "--help", "--version"):
            args = ["scenario", *args]
        return super().parse_args(context, args)

    def format_usage(self, _: click.Context, formatter: click.HelpFormatter) -> None:
        formatter.write_usage("plan", "SCENARIO [OPTIONS]")
        formatter.write_usage("plan", "COMMAND [ARGS]...", prefix="       ")

    def format_options(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        scenario = self.commands["scenario"]
        click.Command.format_options(scenario, context, formatter)
        with formatter.section("Commands"):
            rows = [
                (name, command.get_short_help_str(70))
                for name, command in self.commands.items()
                if not command.hidden
            ]
            formatter.write_dl(rows)
        formatter.write_text("`plan COMMAND --help` explains a command.")


@click.group(cls=_Front)
@click.version_option(package_name="kinolab", prog_name="plan")
def plan() -> None:
    """Plan, verify and animate the motion of a machine through a world.

    SCENARIO is a TOML file, the name of a built-in scenario (`plan list` names them), or an
    environment of the benchmark dynobench, a YAML file.
    """


@plan.command("scenario", hidden=True)
@click.argument("scenario")
@click.option("--planner", metavar="NAME", help="A planner's name, or file.py:Class.")
@click.option("--seed", type=click.IntRange(0), help="Seed of the random numbers.")
@click.option("--time-limit", type=float, metavar="SECONDS", help="Limit of the search.")
@click.option("--max-iterations", type=click.IntRange(1), help="Limit of the search.")
@click.option("--roadmap", metavar="FILE", help="Roadmap of the planner prm, kept between runs.")
@click.option(
    "--jobs",
    type=click.IntRange(1, MAX_JOBS),
    default=1,
    metavar="N",
    help="Searches at once, each with a seed of its own; the first plan wins.",
)
@click.option("--anytime", is_flag=True, help="Plan until the time limit; the shortest plan wins.")
@click.option("--no-optimize", is_flag=True, help="Keep the first motion as it was found.")
@click.option("--set", "overrides", multiple=True, metavar="KEY=VALUE", help="Any scenario key.")
@click.option("--out", type=click.Path(path_type=Path), help="Folder; default runs/<scenario>.")
@click.option("--json", "as_json", is_flag=True, help="Print the report as one JSON object.")
@click.option("--no-animation", is_flag=True, help="Leave all pictures out.")
@click.option("--no-diagnosis", is_flag=True, help="Do not look for why nothing was found.")
@click.option("--live", is_flag=True, help="Show in a browser how the search tree grows.")
@click.option("--no-browser", is_flag=True, help="With --live: only print the page's address.")
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
def _scenario(
    scenario: str,
    planner: str | None,
    seed: int | None,
    time_limit: float | None,
    max_iterations: int | None,
    roadmap: str | None,
    jobs: int,
    anytime: bool,
    no_optimize: bool,
    overrides: tuple[str, ...],
    out: Path | None,
    as_json: bool,
    no_animation: bool,
    no_diagnosis: bool,
    live: bool,
    no_browser: bool,
    quiet: bool,
) -> int:
    """Plan a scenario."""
    from kinolab.runs import PAGE, writable

    if live and jobs > 1:
        raise InputError([Mistake("--live", "a page shows one search.", "Leave --jobs out.")])

    progress = Progress(quiet)
    progress("deriving and compiling the machine")
    shortcuts = {
        "planner.name": planner,
        "planner.seed": seed,
        "planner.time_limit": time_limit,
        "planner.max_iterations": max_iterations,
        "planner.roadmap": roadmap,
    }
    problem = _load(scenario, overrides, shortcuts)
    for warning in problem.world.warnings:
        progress(f"warning: {warning}")
    folder = out or Path("runs") / problem.name
    if not writable(folder):
        raise InputError([Mistake(str(folder), "this folder cannot be written.", "Name another.")])
    with (
        _compilation_told(progress),
        spectators(problem, progress, live=live, browser=not no_browser) as watchers,
    ):
        found, report = _search(
            problem, folder, progress, watchers,
            jobs=jobs, anytime=anytime, optimize=not no_optimize,
        )  # fmt: skip
        if not (found.status == "solved" or INTERRUPTS.seen or no_diagnosis):
            report = _diagnose(problem, found, folder, report, progress)
        if found.trajectory is not None and not INTERRUPTS.seen and not no_animation:
            progress("drawing the pictures")
            _show(problem, found, folder, report)
        watchers.leave(folder / PAGE)
    progress.close()
    if as_json:
        click.echo(json.dumps({"folder": str(folder), **report}, ensure_ascii=False))
    else:
        click.echo(_summary(problem, found, folder, _further(found, report)))
    return INTERRUPTED if INTERRUPTS.seen else found.exit_code


def _compilation_told(progress: Progress) -> AbstractContextManager[object]:
    """Say inside how far compiling is, where anything must be compiled."""
    from kinolab.numerics.compiling import compilation, running

    return compilation(lambda done: progress(running(done.functions, done.seconds), passing=True))


def _load(scenario: str, overrides: Sequence[str], shortcuts: dict[str, Any]) -> Problem:
    """Load a scenario; mistakes in options are reported as the options that were typed."""
    from kinolab.api import load
    from kinolab.scenario import override_place, scenario_path
    from kinolab.search.plugins import seen_from

    INTERRUPTS.libraries_loaded()
    if shortcuts["planner.name"]:  # a file is meant as the shell completes it, from here
        folder = scenario_path(scenario).parent
        shortcuts["planner.name"] = seen_from(folder, shortcuts["planner.name"])
    given = {f"{key}={value}": key for key, value in shortcuts.items() if value is not None}
    try:
        with redirect_stdout(sys.stderr):  # what a user's code prints is no result
            return load(scenario, overrides=[*overrides, *given])
    except InputError as error:
        typed = {
            override_place(
                text
            ): f"--{key.removeprefix('planner.').replace('name', 'planner')}".replace("_", "-")
            for text, key in given.items()
        }
        raise InputError(
            Mistake(typed.get(m.where, m.where), m.what, m.remedy) for m in error.mistakes
        ) from error


def _search(
    problem: Problem,
    folder: Path,
    progress: Progress,
    watchers: Spectators,
    *,
    jobs: int,
    anytime: bool,
    optimize: bool,
) -> tuple[Plan, dict[str, Any]]:
    """Search, and write what was found before it is drawn; return it with its report."""
    from kinolab.runs import write_run
    from kinolab.solve import solve

    section = problem.scenario.planner
    optimising = optimize and section.improve > 0

    def report(iterations: int, elapsed: float) -> None:
        spent = f"{elapsed:.1f} of {section.time_limit:g} s"
        progress(f"{section.name}: {iterations} iterations, {spent}", passing=True)

    def write(found: Plan) -> dict[str, Any]:
        with INTERRUPTS.writing():
            return write_run(folder, problem, found)

    def watch(budget: Budget) -> None:
        INTERRUPTS.ask(budget.end)
        watchers.watch(budget)

    def improved(found: Plan) -> None:
        watchers.found(found)
        if anytime or optimising:
            write(found)
            progress(_progress_of(found, anytime=anytime))

    seeds = f"seed {section.seed}"
    if jobs > 1:
        seeds = f"seeds {section.seed} to {section.seed + jobs - 1}"
    progress(f"searching with {section.name}, {seeds}")
    with INTERRUPTS.asking(), redirect_stdout(sys.stderr):
        found = solve(
            problem,
            jobs=jobs,
            anytime=anytime,
            optimize=optimize,
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
        return found, write(found)


def _progress_of(found: Plan, *, anytime: bool) -> str:
    """Word a plan that is better than all before."""
    first, last = found.improvements[0], min(found.improvements, key=lambda one: one.duration)
    if anytime:
        return f"seed {last.seed}: {last.duration:.2f} s of motion, after {last.after:.1f} s"
    if first is last:
        return f"optimising {first.duration:.2f} s of motion"
    return (
        f"optimising: {first.duration:.2f} s -> {last.duration:.2f} s of motion, "
        f"after {last.after:.1f} s"
    )


def _show(problem: Problem, found: Plan, folder: Path, report: dict[str, Any]) -> None:
    """Write the film, the page and the scene of a motion."""
    from kinolab.files import write_whole
    from kinolab.show.film.animation import animate
    from kinolab.show.view import write_scene

    assert found.trajectory is not None
    write_whole(folder / "animation.gif", animate(problem, found.trajectory))
    write_scene(folder, problem, found.trajectory, report, found.graph)


def _diagnose(
    problem: Problem, found: Plan, folder: Path, report: dict[str, Any], progress: Progress
) -> dict[str, Any]:
    """Look for why no plan was found, and return the report with what was found out."""
    from kinolab.analyze.diagnose import diagnose
    from kinolab.runs import add_diagnosis

    with redirect_stdout(sys.stderr):  # what a user's planner prints is no result
        diagnosis = diagnose(problem, found, progress=progress)
    INTERRUPTS.raise_if_seen()
    with INTERRUPTS.writing():
        return add_diagnosis(folder, report, diagnosis.to_json())


def _further(found: Plan, report: dict[str, Any]) -> list[str]:
    """Return what a diagnosis says that the plan's own message does not."""
    sentences = report["diagnosis"].get("sentences", ())
    return [sentence for sentence in sentences if sentence not in found.message]


def _summary(problem: Problem, found: Plan, folder: Path, why: Sequence[str] = ()) -> str:
    from kinolab.problem.goal_entries import distance_text

    lines = [f"{found.status}: {found.message}"]
    if found.interrupted and found.status != "interrupted":
        lines[0] += " Interrupted before the time was over."
    if found.trajectory is not None:
        lines.append(
            f"  motion of {found.trajectory.duration:.2f} s{_before(found)}, ending "
            f"{distance_text(problem, found.trajectory.x[-1])} from the goal's centre, "
            f"{found.iterations} iterations in "
            f"{found.timings['search']:.2f} s"
        )
    if found.refused:
        lines.append(f"  {_refusals(found.refused)}")
    if len(found.attempts) > 1:
        lines.append(f"  seed {found.seed} of {_ends(found)}")
    if found.certificate is not None:
        passed = sum(check.passed for check in found.certificate.checks)
        lines.append(f"  {passed} of {len(found.certificate.checks)} checks passed")
        lines += [f"  {check}" for check in found.certificate.failures]
    lines += [f"  {sentence}" for sentence in why]
    return "\n".join([*lines, f"  written to {folder}"])


def _before(found: Plan) -> str:
    """Word the duration of the motion that a search gave, where it was made shorter."""
    raw = found.statistics.get("raw_duration")
    return f" (found with {raw:.2f} s)" if raw not in {None, found.cost} else ""


def _refusals(refused: Mapping[str, int]) -> str:
    """Word how many motions the verifier refused, and why."""
    count = sum(refused.values())
    ways = "; ".join(f"{checks}: {times}" for checks, times in sorted(refused.items()))
    return f"{count} {'motion' if count == 1 else 'motions'} refused by verification ({ways})"


def _ends(found: Plan) -> str:
    """Word how many seeds ended in which way."""
    counts = Counter(attempt.status for attempt in found.attempts)
    ways = ", ".join(f"{count} {status}" for status, count in sorted(counts.items()))
    return f"{len(found.attempts)} ({ways})"


@plan.command("check")
@click.argument("folders", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def _check(folders: Sequence[Path], as_json: bool) -> int:
    """Verify finished runs from their files alone."""
    from kinolab.runs import check_run, check_to_json, margin_to_json

    INTERRUPTS.libraries_loaded()
    certificates = {str(folder): check_run(folder) for folder in folders}
    if as_json:
        runs = [
            {
                "folder": folder,
                "passed": certificate.passed,
                "checks": [check_to_json(check) for check in certificate.checks],
                "margin": margin_to_json(certificate),
            }
            for folder, certificate in certificates.items()
        ]
        click.echo(json.dumps({"runs": runs}, ensure_ascii=False))
    else:
        for folder, certificate in certificates.items():
            click.echo(f"{folder}: {'passed' if certificate.passed else 'FAILED'}")
            click.echo("\n".join(f"  {check}" for check in certificate.checks))
            if certificate.margin is not None:
                click.echo(f"  {certificate.margin}")
    return 0 if all(certificate.passed for certificate in certificates.values()) else FAILED


plan.add_command(execute_plan)
plan.add_command(plot)
plan.add_command(write_video)
plan.add_command(write_gallery)
plan.add_command(view)


@plan.command("list")
@click.argument(
    "group", type=click.Choice(["scenarios", "systems", "planners", "options"]), required=False
)
@click.argument("names", nargs=-1)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def _list(group: str | None, names: tuple[str, ...], as_json: bool) -> int:
    """Name the scenarios, systems and planners.

    `plan list planners` shows the settings of every planner, `plan list planners NAME` those of
    one; NAME may be file.py:Class. `plan list options` shows all numbers of the optimiser.
    """
    from kinolab.cli.listing import listed, listed_as_text

    with redirect_stdout(sys.stderr):  # what a planner's file prints is no result
        if as_json:
            text = json.dumps(listed(group, names), ensure_ascii=False)
        else:
            text = listed_as_text(group, names)
    click.echo(text)
    return 0


@plan.command("equations")
@click.argument("what")
@click.option("--latex", is_flag=True, help="Print LaTeX.")
def _equations(what: str, latex: bool) -> int:
    """Print the equations of motion of WHAT: a system, a scenario, or machine.py:function."""
    from kinolab.loading import find_machine

    INTERRUPTS.libraries_loaded()
    equations = find_machine(what).equations()
    click.echo(equations.latex() if latex else equations.text())
    return 0


@plan.command("describe")
@click.argument("what")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def _describe(what: str, as_json: bool) -> int:
    """Say what WHAT is and whether it can be controlled."""
    from kinolab.analyze.describe import describe, described_as_text, description_to_json
    from kinolab.loading import find_machine

    INTERRUPTS.libraries_loaded()
    with redirect_stdout(sys.stderr):  # what a user's code prints is no result
        found = describe(find_machine(what))
    if as_json:
        click.echo(json.dumps(description_to_json(found), ensure_ascii=False))
    else:
        click.echo(described_as_text(found))
    return 0


@plan.command("simulate")
@click.argument("what")
@click.option("--duration", type=float, default=5.0, show_default=True, metavar="SECONDS")
@click.option("--start", multiple=True, metavar="NAME=VALUE", help="A state at the beginning.")
@click.option(
    "--inputs", type=click.Path(path_type=Path), help="CSV with t and inputs; default: none act."
)
@click.option("--set", "overrides", multiple=True, metavar="KEY=VALUE", help="Any scenario key.")
@click.option("--out", type=click.Path(path_type=Path), help="Folder; default runs/<name>.")
@click.option("--no-animation", is_flag=True, help="Leave all pictures out.")
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
def _simulate(
    what: str,
    duration: float,
    start: tuple[str, ...],
    inputs: Path | None,
    overrides: tuple[str, ...],
    out: Path | None,
    no_animation: bool,
    quiet: bool,
) -> int:
    """Let WHAT move by itself: a system, a scenario, or machine.py:function."""
    from kinolab.analyze.simulate import simulate
    from kinolab.loading import build_problem, find_scenario
    from kinolab.runs import write_run
    from kinolab.solve import Plan

    INTERRUPTS.libraries_loaded()
    progress = Progress(quiet)
    progress("deriving and compiling the machine")
    given = [*overrides, *(f"start.{entry}" for entry in start)]
    problem = build_problem(find_scenario(what, overrides=given), planning=False)
    trajectory = simulate(problem, duration, inputs)
    distance = problem.goal_distance(trajectory.x[-1])
    moved = Plan("simulated", trajectory, None, "none", 0, 0, distance, message="Moved by itself.")
    folder = out or Path("runs") / f"{problem.name}_simulated"
    with INTERRUPTS.writing():
        report = write_run(folder, problem, moved)
    if not no_animation:
        progress("drawing the pictures")
        with _compilation_told(progress):
            _show(problem, moved, folder, report)
    progress.close()
    click.echo(f"simulated: {trajectory.duration:g} s\n  written to {folder}")
    return moved.exit_code


@plan.command("examine")
@click.argument("what")
def _examine(what: str) -> int:
    """Check the laws of mechanics on WHAT, and its steps, and say what is odd."""
    from kinolab.analyze.examine import examine
    from kinolab.loading import find_scenario, find_system

    INTERRUPTS.libraries_loaded()
    scenario = find_scenario(what)
    findings = list(examine(find_system(scenario), scenario.integration))
    click.echo("\n".join(map(str, findings)))
    return 0 if all(finding.holds for finding in findings) else FAILED


@plan.command("new")
@click.argument("name")
def _new(name: str) -> int:
    """Write a commented machine NAME.py and a scenario NAME.toml to start from."""
    from kinolab.cli.new import write_starter

    for path in write_starter(name, Path()):
        click.echo(f"written {path}")
    click.echo(f"next: plan {name}.toml")
    return 0


@plan.command("warm-up")
@click.option(
    "--jobs",
    type=click.IntRange(1, MAX_JOBS),
    metavar="N",
    help="Processes at most; default: as many as there are processors.",
)
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
def _warm_up(jobs: int | None, quiet: bool) -> int:
    """Compile all inner loops now, so that no plan has to wait for it.

    It is done once on a computer, and again after an update of kinolab, numba or Python.
    """
    from kinolab.cli.warm_up import warm_up
    from kinolab.numerics.compiling import running

    INTERRUPTS.libraries_loaded()
    progress, begun, functions = Progress(quiet), time.monotonic(), 0
    progress("looking for what is not compiled yet")

    def told(so_far: int) -> None:
        progress(running(so_far, time.monotonic() - begun), passing=True)

    for part in warm_up(jobs=jobs, progress=told):
        progress.close()
        functions += part.functions
        made = f"{part.functions} functions in {part.seconds:.1f} s"
        click.echo(f"{part.part}: {made if part.functions else 'nothing to compile'}")
    taken = f"{functions} functions in {time.monotonic() - begun:.1f} s"
    click.echo(f"compiled {taken}" if functions else "everything was compiled before")
    return 0


def execute(arguments: list[str]) -> int:
    """Run a command and return its exit code; errors become sentences on stderr."""
    try:
        with plan.make_context("plan", arguments) as context:
            result = plan.invoke(context)
        sys.stdout.flush()
        return result if isinstance(result, int) else 0
    except click.exceptions.Exit as leaving:
        return leaving.exit_code
    except click.ClickException as error:
        error.show(sys.stderr)
        return USAGE
    except KinolabError as error:
        return _explain(error)
    except click.Abort:
        raise KeyboardInterrupt from None
    except MemoryError:
        print("error: out of memory", file=sys.stderr)
        return RESOURCES
    except BrokenPipeError:
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115  # nobody reads any more
        return 0
    except OSError as error:
        print(f"error: {error}", file=sys.stderr)
        return USAGE
    except Exception:
        INTERRUPTS.raise_if_seen()  # what a library makes of it
        traceback.print_exc()
        print("error: this is a mistake in kinolab; please report it.", file=sys.stderr)
        return INTERNAL


def _explain(error: KinolabError) -> int:
    for line in str(error).splitlines():
        print(f"error: {escaped(line)}", file=sys.stderr)
    return error.exit_code
