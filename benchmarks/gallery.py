"""Every built-in scenario, planned from the command line with several seeds.

    python benchmarks/gallery.py [NAME ...] [--seeds N] [--planner NAME] [--time-limit SECONDS]
                                 [--jobs N] [--optimise SECONDS] [--json FILE] [--keep DIR]

Prints a Markdown table. Every plan is searched for in a process of its own, as users do, and what
it wrote is then judged by ``plan check`` in another one. The search is timed by kinolab itself,
imports and compilation apart. What ends without a verified plan counts as if it had searched for
the whole time limit. Ctrl-C ends it with a table of the runs that are finished.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import platform
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any

AIMED = ("goal_bias=0.4", "goal_region_scale=10.0")
TUNED = {  # settings of OMPL's RRT that were found by hand; other planners run as they are
    ("rrt", "crane_factory"): ("max_steps=12", *AIMED),
    ("rrt", "diffdrive_warehouse"): ("max_steps=15", *AIMED),
    ("rrt", "pendulum_swingup"): ("max_steps=8",),
    ("rrt", "snakeboard_park"): ("max_steps=15", *AIMED),
    ("rrt", "submarine_corridor"): ("max_steps=15", *AIMED),
    ("rrt", "two_cranes"): ("max_steps=5", *AIMED),
    ("rrt", "vehicle_parking"): ("max_steps=15", *AIMED),
}
ENTER = "from kinolab.cli import main; main()"
GRACE = 120.0  # [s] for imports, compilation and verification, beyond the limit of the search
SOLVED = 0  # the exit code
OPTIMISER = Path(__file__).with_name("gallery_optimised.py")
HEADINGS = (
    *("scenario", "system", "planner", "solved", "checked", "search, median [s]"),
    *("search, worst [s]", "plan, median [s]", "other exits"),
)
OPTIMISED = ("optimised, median [s]", "share of the plan", "from the goal, worst", "not optimised")
LEGEND = """\
- *solved*: runs that ended with a verified plan, exit code 0; *checked*: how many of these
  `plan check` confirmed from their files alone.
- *search*: time of the search alone; a run without a verified plan counts as the limit, and ≥
  marks a figure in which one does.
- *plan*: duration of the motion that was found, as the search gave it.
- *other exits*: exit codes of the rest, and how often; a negative one is a signal."""
OPTIMISED_LEGEND = """\
- *optimised*: duration after repair and shortening; *share*: of that of the plan it began with.
  Both are medians of the runs whose optimised motion was verified. *from the goal*: norm of all
  errors at its end, in SI units; *not optimised*: solved runs that left no such motion."""


@dataclass(frozen=True)
class Case:
    """A scenario and who is to solve it, by their names."""

    scenario: str
    system: str
    planner: str


@dataclass(frozen=True)
class Run:
    """How one search ended.

    Attributes:
        scenario: Its name.
        seed: Of the random numbers.
        exit_code: Of ``plan``; None where the run was killed because it took too long.
        check_code: Of ``plan check``; None where there was nothing to check, or it was killed.
        wall: Time of the whole process in [s].
        search: Time of the search in [s]; None where nothing was reported, as are the next two.
        iterations: Number of extensions.
        duration: Of the motion in [s].
        complaint: What the run said where it gave no verified plan.
        optimised: Duration in [s] of what the optimiser made of it; None where it was not asked or
            nothing came out that the verifier accepts, as is the next one.
        goal_distance: Norm of all errors at its end, in SI units.
    """

    scenario: str
    seed: int
    exit_code: int | None
    check_code: int | None
    wall: float
    search: float | None
    iterations: int | None
    duration: float | None
    complaint: str
    optimised: float | None = None
    goal_distance: float | None = None

    @property
    def solved(self) -> bool:
        """Whether it ended with a verified plan."""
        return self.exit_code == SOLVED and self.search is not None

    def __str__(self) -> str:
        exit_code = "killed" if self.exit_code is None else f"exit {self.exit_code}"
        search = "" if self.search is None else f", search {self.search:.1f} s"
        complaint = f": {self.complaint}" if self.complaint else ""
        return f"{self.scenario}, seed {self.seed}: {exit_code}{search}{complaint}"


@dataclass(frozen=True)
class Ended:
    """A process that has ended; ``code`` is None where it was killed at its limit."""

    code: int | None
    stdout: str
    stderr: str


class Processes:
    """Starts processes, several at a time, and ends all of them at once.

    Each has a session of its own, so that Ctrl-C on a terminal does not reach it: a search would
    end early and be counted.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._live: set[subprocess.Popen[str]] = set()
        self._closed = False

    def run(self, command: Sequence[str], limit: float) -> Ended:
        """Run a command; kill it and its children after ``limit`` seconds.

        Raises:
            InterruptedError: If ``close`` was called.
        """
        process = self._start(command)
        try:
            stdout, stderr = process.communicate(timeout=limit)
            code: int | None = process.returncode
        except subprocess.TimeoutExpired:
            _kill(process)
            stdout, stderr = process.communicate()
            code = None
        finally:
            with self._lock:
                self._live.discard(process)
        if self._closed:
            raise InterruptedError
        return Ended(code, stdout, stderr)

    def _start(self, command: Sequence[str]) -> subprocess.Popen[str]:
        with self._lock:
            if self._closed:
                raise InterruptedError
            process = subprocess.Popen(
                command,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                start_new_session=True,
            )
            self._live.add(process)
        return process

    def close(self) -> None:
        """Kill what runs and start nothing any more."""
        with self._lock:
            self._closed = True
            for process in self._live:
                _kill(process)


def _kill(process: subprocess.Popen[str]) -> None:
    """Kill a process and its children, which share its session."""
    if process.poll() is None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)


def plan(processes: Processes, case: Case, seed: int, options: argparse.Namespace) -> Run:
    """Search for a plan with one seed, and check what was written."""
    folder = Path(options.keep) / f"{case.scenario}-{seed}"
    limit = options.time_limit
    arguments = [
        *(case.scenario, "--seed", str(seed), "--time-limit", str(limit), "--out", str(folder)),
        *("--no-optimize", "--no-animation", "--no-diagnosis", "--quiet", "--json"),
        *(["--planner", options.planner] if options.planner else []),
    ]
    for setting in TUNED.get((case.planner, case.scenario), ()):
        arguments += ["--set", f"planner.{setting}"]
    begun = time.perf_counter()
    ended = processes.run([sys.executable, "-c", ENTER, *arguments], limit + GRACE)
    wall = time.perf_counter() - begun
    check_code = None
    if ended.code == SOLVED:
        check_code = processes.run([sys.executable, "-c", ENTER, "check", str(folder)], GRACE).code
    run = result(case, seed, ended, check_code, wall)
    return optimised(processes, run, folder, options) if run.solved else run


def optimised(processes: Processes, run: Run, folder: Path, options: argparse.Namespace) -> Run:
    """Return a run with what the optimiser makes of its plan within its time, if it is to."""
    if not getattr(options, "optimise", 0.0):
        return run
    command = [sys.executable, str(OPTIMISER), str(folder), str(options.optimise)]
    ended = processes.run(command, options.optimise + GRACE)
    if ended.code == SOLVED:
        return replace(run, **report_in(ended.stdout))
    last = ended.stderr.strip().rpartition("\n")[2]
    return replace(run, complaint=f"not optimised: {last or 'it took too long'}")


def result(case: Case, seed: int, ended: Ended, check_code: int | None, wall: float) -> Run:
    """Read what a process reported."""
    report = report_in(ended.stdout)
    complaint = ended.stderr.strip().rpartition("\n")[2] or report.get("message", "")
    return Run(
        scenario=case.scenario,
        seed=seed,
        exit_code=ended.code,
        check_code=check_code,
        wall=wall,
        search=report.get("timings", {}).get("search"),
        iterations=report.get("iterations"),
        duration=report.get("duration"),
        complaint="" if ended.code == SOLVED else complaint,
    )


def report_in(text: str) -> dict[str, Any]:
    """Return the report that a run printed; empty where it did not come to that."""
    try:
        report = json.loads(text)
    except ValueError:
        return {}
    return report if isinstance(report, dict) else {}


def table(cases: Iterable[Case], runs: Sequence[Run], limit: float) -> str:
    """Return the runs as a Markdown table, one row per scenario that was run.

    Args:
        cases: What was to be run, in the order of the rows.
        runs: What was run.
        limit: Of the search, in [s], which a run without a verified plan counts as.
    """
    further = any(run.optimised is not None or (run.solved and run.complaint) for run in runs)
    headings = [*HEADINGS, *(OPTIMISED if further else ())]
    rows = [headings, ["---"] * len(headings)]
    for case in cases:
        own = [run for run in runs if run.scenario == case.scenario]
        if own:
            known = [*cells(own, limit), *(optimised_cells(own) if further else ())]
            rows.append([case.scenario, case.system, case.planner, *known])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def cells(runs: Sequence[Run], limit: float) -> list[str]:
    """Return the figures of one scenario's runs as text."""
    solved = [run for run in runs if run.solved]
    checked = sum(run.check_code == 0 for run in solved)
    durations = [run.duration for run in solved if run.duration is not None]
    return [
        f"{len(solved)}/{len(runs)}",
        f"{checked}/{len(solved)}" if solved else "–",
        *search_times(runs, limit),
        f"{median(durations):.1f}" if durations else "–",
        other_exits(runs),
    ]


def optimised_cells(runs: Sequence[Run]) -> list[str]:
    """Return what the optimiser made of one scenario's runs as text."""
    own = [run for run in runs if run.optimised is not None]
    left = f"{sum(run.solved for run in runs) - len(own)}"
    if not own:
        return ["–", "–", "–", left]
    return [
        f"{median(run.optimised for run in own):.1f}",
        f"{median(shares(own)):.0%}",
        f"{max(run.goal_distance for run in own):.1e}",
        left,
    ]


def shares(runs: Iterable[Run]) -> list[float]:
    """Return durations after optimisation as shares of those before it."""
    return [run.optimised / run.duration for run in runs if run.optimised and run.duration]


def search_times(runs: Sequence[Run], limit: float) -> tuple[str, str]:
    """Return median and worst time of the search, marked where a run without a plan counts."""
    found = sorted(run.search for run in runs if run.solved and run.search is not None)
    times = [*found, *[limit] * (len(runs) - len(found))]
    middle = len(times) // 2  # of the two in the middle of an even number, the later one
    return (
        f"{'≥ ' if middle >= len(found) else ''}{median(times):.1f}",
        f"{'≥ ' if len(found) < len(times) else ''}{times[-1]:.1f}",
    )


def other_exits(runs: Iterable[Run]) -> str:
    """Return the exit codes other than that of a solved run, and how often each came."""
    codes = Counter(
        "killed" if run.exit_code is None else str(run.exit_code) for run in runs if not run.solved
    )
    return ", ".join(f"{code} ({count})" for code, count in sorted(codes.items())) or "–"


def describe() -> str:
    """Return what this ran on, and the versions."""
    from kinolab.runs.report import versions
    from kinolab.studies.hardware import processor

    there = {name: number for name, number in versions().items() if number != "absent"}
    named = ", ".join(f"{'Python' if n == 'python' else n} {v}" for n, v in there.items())
    return f"{processor()}, {os.cpu_count()} cores, {platform.system()}\n\n{named}"


def circumstances(options: argparse.Namespace, runs: Sequence[Run], planned: int) -> Iterator[str]:
    """Yield sentences that say how the times were taken."""
    seeds = "seed 1" if options.seeds == 1 else f"seeds 1 to {options.seeds}"
    yield f"Search limit {options.time_limit:g} s, {seeds}."
    if options.jobs > 1:
        yield f"Times were taken with {options.jobs} runs side by side."
    if found := shares(runs):
        yield f"{options.optimise:g} s of optimisation each leave {median(found):.0%} of the"
        yield f"duration, in the median of {len(found)} plans."
    killed = sum(run.exit_code is None for run in runs)
    if killed:
        longest = options.time_limit + GRACE
        yield f"{killed} of the runs took longer than {longest:g} s and were killed."
    if len(runs) < planned:
        yield f"Interrupted after {len(runs)} of {planned} runs."


def run_all(cases: Sequence[Case], options: argparse.Namespace) -> list[Run]:
    """Run every case with every seed; return what was finished before Ctrl-C."""
    processes, finished = Processes(), []
    with ThreadPoolExecutor(options.jobs) as pool:
        futures = [
            pool.submit(plan, processes, case, seed, options)
            for case in cases
            for seed in range(1, options.seeds + 1)
        ]
        try:
            for run in completed(futures):
                finished.append(run)
                print(run, file=sys.stderr)
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)
            processes.close()
    return finished


def completed(futures: Sequence[Future[Run]]) -> Iterator[Run]:
    """Yield runs as they end."""
    for future in as_completed(futures):
        yield future.result()


def cases_of(options: argparse.Namespace) -> list[Case]:
    """Return the scenarios that were named, or all."""
    from kinolab.scenario import builtin_scenarios, load_scenario

    known = builtin_scenarios()
    scenarios = {name: load_scenario(known[name]) for name in options.names or known}
    return [
        Case(name, scenario.system.name or "–", options.planner or scenario.planner.name)
        for name, scenario in scenarios.items()
    ]


def arguments() -> argparse.Namespace:
    """Read the command line."""
    from kinolab.scenario import builtin_scenarios

    parser = argparse.ArgumentParser(description="Plan every scenario with several seeds.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="scenarios; default: all")
    parser.add_argument("--seeds", type=int, default=10, metavar="N", help="seeds 1 to N")
    parser.add_argument("--planner", metavar="NAME", help="planner, instead of the scenario's")
    parser.add_argument("--time-limit", type=float, default=120.0, metavar="SECONDS")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="runs side by side")
    parser.add_argument(
        "--optimise", type=float, default=0.0, metavar="SECONDS", help="of each plan; default: none"
    )
    parser.add_argument("--json", metavar="FILE", help="write every run to a file")
    parser.add_argument("--keep", metavar="DIR", help="keep the folders of the runs in DIR")
    options = parser.parse_args()
    unknown = set(options.names) - set(builtin_scenarios())
    if unknown:
        parser.error(f"no scenario is called {', '.join(sorted(unknown))}")
    if min(options.seeds, options.jobs) < 1 or options.time_limit <= 0:
        parser.error("--seeds, --jobs and --time-limit must be positive")
    if options.optimise < 0:
        parser.error("--optimise must not be negative")
    return options


def write_json(path: str, options: argparse.Namespace, runs: Sequence[Run], text: str) -> None:
    """Write every run, and how the times were taken."""
    content = {
        "machine": describe().splitlines(),
        "circumstances": text,
        "time_limit": options.time_limit,
        "jobs": options.jobs,
        "runs": [asdict(run) for run in sorted(runs, key=lambda run: (run.scenario, run.seed))],
    }
    Path(path).write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", "utf-8")


def main() -> int:
    """Print the table; return 130 if it was interrupted."""
    options = arguments()
    cases = cases_of(options)
    planned = len(cases) * options.seeds
    with tempfile.TemporaryDirectory() as folder:
        options.keep = options.keep or folder
        runs = run_all(cases, options)
    text = " ".join(circumstances(options, runs, planned))
    legend = f"{LEGEND}\n{OPTIMISED_LEGEND}" if options.optimise else LEGEND
    print(f"{describe()}\n\n{text}\n\n{table(cases, runs, options.time_limit)}\n\n{legend}")
    if options.json:
        write_json(options.json, options, runs, text)
    return 0 if len(runs) == planned else 130


if __name__ == "__main__":
    sys.exit(main())
