"""The command line: ``plan SCENARIO`` and its sisters. Every import beyond click comes late."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from kinolab.errors import InputError, KinolabError, Mistake

if TYPE_CHECKING:
    from kinolab.planning import Plan
    from kinolab.problem import Problem
    from kinolab.search import Budget

USAGE, RESOURCES, FAILED, INTERNAL, INTERRUPTED = 2, 6, 7, 70, 130


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

    SCENARIO is a TOML file or the name of a built-in scenario; `plan list` names them.
    """


@plan.command("scenario", hidden=True)
@click.argument("scenario")
@click.option("--planner", metavar="NAME", help="A planner's name, or file.py:Class.")
@click.option("--seed", type=click.IntRange(0), help="Seed of the random numbers.")
@click.option("--time-limit", type=float, metavar="SECONDS", help="Limit of the search.")
@click.option("--max-iterations", type=click.IntRange(1), help="Limit of the search.")
@click.option("--roadmap", metavar="FILE", help="Roadmap of the planner prm, kept between runs.")
@click.option("--set", "overrides", multiple=True, metavar="KEY=VALUE", help="Any scenario key.")
@click.option("--out", type=click.Path(path_type=Path), help="Folder; default runs/<scenario>.")
@click.option("--json", "as_json", is_flag=True, help="Print the report as one JSON object.")
@click.option("--no-animation", is_flag=True, help="Leave animation.gif out.")
@click.option("--quiet", is_flag=True, help="No progress on stderr.")
def _scenario(
    scenario: str,
    planner: str | None,
    seed: int | None,
    time_limit: float | None,
    max_iterations: int | None,
    roadmap: str | None,
    overrides: tuple[str, ...],
    out: Path | None,
    as_json: bool,
    no_animation: bool,
    quiet: bool,
) -> int:
    """Plan a scenario."""
    from kinolab.runs import writable, write_run

    progress = _Progress(quiet)
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
    found = _search(problem, progress)
    report = write_run(folder, problem, found)  # before it is drawn: drawing may be interrupted
    if found.trajectory is not None and found.status != "interrupted" and not no_animation:
        progress("drawing the animation")
        _animate(problem, found, folder)
    progress.close()
    if as_json:
        click.echo(json.dumps({"folder": str(folder), **report}, ensure_ascii=False))
    else:
        click.echo(_summary(found, folder))
    return found.exit_code


def _load(scenario: str, overrides: Sequence[str], shortcuts: dict[str, Any]) -> Problem:
    """Load a scenario; mistakes in options are reported as the options that were typed."""
    from kinolab.loading import load
    from kinolab.plugins import seen_from
    from kinolab.scenario import override_place, scenario_path

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


def _search(problem: Problem, progress: _Progress) -> Plan:
    from kinolab.planning import solve

    def report(iterations: int, elapsed: float) -> None:
        limit = problem.scenario.planner.time_limit
        name = problem.scenario.planner.name
        progress(f"{name}: {iterations} iterations, {elapsed:.1f} of {limit:g} s", passing=True)

    name = problem.scenario.planner.name
    progress(f"searching with {name}, seed {problem.scenario.planner.seed}")
    budgets: list[Budget] = []
    with _ending_on_interrupt(budgets), redirect_stdout(sys.stderr):
        found = solve(problem, progress=report, watch=budgets.append)
    progress("verified" if found.certificate else found.message)
    return found


@contextmanager
def _ending_on_interrupt(budgets: list[Budget]) -> Iterator[None]:
    """Let the first Ctrl-C end the search and keep what was found; the second ends everything."""

    def stop(*_: Any) -> None:
        if not budgets or budgets[0].interrupted:
            raise KeyboardInterrupt
        budgets[0].interrupted = True

    before = signal.signal(signal.SIGINT, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _animate(problem: Problem, found: Plan, folder: Path) -> None:
    from kinolab.animation import animate
    from kinolab.files import write_whole

    assert found.trajectory is not None
    write_whole(folder / "animation.gif", animate(problem, found.trajectory))


def _summary(found: Plan, folder: Path) -> str:
    lines = [f"{found.status}: {found.message}"]
    if found.trajectory is not None:
        lines.append(
            f"  motion of {found.trajectory.duration:.2f} s, ending "
            f"{found.goal_distance:.3g} from the goal's centre, {found.iterations} iterations in "
            f"{found.timings['search']:.2f} s"
        )
    if found.certificate is not None:
        passed = sum(check.passed for check in found.certificate.checks)
        lines.append(f"  {passed} of {len(found.certificate.checks)} checks passed")
        lines += [f"  {check}" for check in found.certificate.failures]
    return "\n".join([*lines, f"  written to {folder}"])


@plan.command("check")
@click.argument("folders", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def _check(folders: Sequence[Path], as_json: bool) -> int:
    """Verify finished runs from their files alone."""
    from kinolab.runs import check_run, check_to_json

    certificates = {str(folder): check_run(folder) for folder in folders}
    if as_json:
        runs = [
            {
                "folder": folder,
                "passed": certificate.passed,
                "checks": [check_to_json(check) for check in certificate.checks],
            }
            for folder, certificate in certificates.items()
        ]
        click.echo(json.dumps({"runs": runs}, ensure_ascii=False))
    else:
        for folder, certificate in certificates.items():
            click.echo(f"{folder}: {'passed' if certificate.passed else 'FAILED'}")
            click.echo("\n".join(f"  {check}" for check in certificate.checks))
    return 0 if all(certificate.passed for certificate in certificates.values()) else FAILED


@plan.command("list")
@click.argument("group", type=click.Choice(["scenarios", "systems", "planners"]), required=False)
@click.argument("names", nargs=-1)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def _list(group: str | None, names: tuple[str, ...], as_json: bool) -> int:
    """Name the scenarios, systems and planners.

    `plan list planners` shows the settings of every planner, `plan list planners NAME` those of
    one; NAME may be file.py:Class.
    """
    from kinolab.listing import listed, listed_as_text

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

    equations = find_machine(what).equations()
    click.echo(equations.latex() if latex else equations.text())
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
@click.option("--no-animation", is_flag=True, help="Leave animation.gif out.")
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
    from kinolab.loading import build_problem, find_scenario
    from kinolab.planning import Plan
    from kinolab.runs import write_run
    from kinolab.simulation import simulate

    progress = _Progress(quiet)
    progress("deriving and compiling the machine")
    given = [*overrides, *(f"start.{entry}" for entry in start)]
    problem = build_problem(find_scenario(what, overrides=given), planning=False)
    trajectory = simulate(problem, duration, inputs)
    distance = problem.goal_distance(trajectory.x[-1])
    moved = Plan("simulated", trajectory, None, "none", 0, 0, distance, message="Moved by itself.")
    folder = out or Path("runs") / f"{problem.name}_simulated"
    write_run(folder, problem, moved)
    if not no_animation:
        progress("drawing the animation")
        _animate(problem, moved, folder)
    progress.close()
    click.echo(f"simulated: {trajectory.duration:g} s\n  written to {folder}")
    return moved.exit_code


@plan.command("examine")
@click.argument("what")
def _examine(what: str) -> int:
    """Check the laws of mechanics on WHAT and say what is odd."""
    from kinolab.examination import examine
    from kinolab.loading import find_machine

    findings = list(examine(find_machine(what)))
    click.echo("\n".join(map(str, findings)))
    return 0 if all(finding.holds for finding in findings) else FAILED


@plan.command("new")
@click.argument("name")
def _new(name: str) -> int:
    """Write a commented machine NAME.py and a scenario NAME.toml to start from."""
    from kinolab.starter import write_starter

    for path in write_starter(name, Path()):
        click.echo(f"written {path}")
    click.echo(f"next: plan {name}.toml")
    return 0


class _Interrupts:
    """Remembers Ctrl-C: some libraries swallow the exception while they import or compile."""

    seen = False

    @classmethod
    def arrive(cls, *_: Any) -> None:
        """Handle the signal."""
        cls.seen = True
        raise KeyboardInterrupt

    @classmethod
    def raise_if_seen(cls) -> None:
        """Raise again what was swallowed; called between the stages of a command."""
        if cls.seen:
            raise KeyboardInterrupt

    @classmethod
    @contextmanager
    def watched(cls) -> Iterator[None]:
        """Handle Ctrl-C inside, where Python lets this thread do so."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        cls.seen = False
        before = signal.signal(signal.SIGINT, cls.arrive)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)


class _Progress:
    """Lines on stderr: one that is overwritten on a terminal, plain ones elsewhere."""

    def __init__(self, quiet: bool) -> None:
        self._quiet = quiet
        self._terminal = sys.stderr.isatty()
        self._last = 0.0

    def __call__(self, text: str, *, passing: bool = False) -> None:
        """Say what is happening; a passing line may be left out."""
        _Interrupts.raise_if_seen()
        if self._quiet or (passing and not self._terminal and time.monotonic() < self._last + 5):
            return
        self._last = time.monotonic()
        print(f"\r\033[K{text}" if self._terminal else text, end=self._end, file=sys.stderr)
        sys.stderr.flush()

    @property
    def _end(self) -> str:
        return "" if self._terminal else "\n"

    def close(self) -> None:
        """Clear the line on a terminal."""
        _Interrupts.raise_if_seen()
        if self._terminal and not self._quiet:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code; errors become sentences on stderr."""
    try:
        given = list(sys.argv[1:] if arguments is None else arguments)
        with _Interrupts.watched(), plan.make_context("plan", given) as context:
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
    except (KeyboardInterrupt, click.Abort):
        print("\ninterrupted", file=sys.stderr)
        return INTERRUPTED
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
        traceback.print_exc()
        print("error: this is a mistake in kinolab; please report it.", file=sys.stderr)
        return INTERNAL


def _explain(error: KinolabError) -> int:
    for line in str(error).splitlines():
        print(f"error: {line}", file=sys.stderr)
    return error.exit_code


def main() -> None:
    """Enter from the console script."""
    sys.exit(run())
