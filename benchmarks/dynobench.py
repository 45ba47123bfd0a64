"""The 43 problems of the benchmark dynobench, beside what others published for them.

    python benchmarks/dynobench.py [--problems NAME,…] [--machines NAME,…] [--seeds 3] [--limit 20]
                                   [--jobs N] [--planner NAME] [--environments DIR]
                                   [--results FILE.jsonl] [--resume] [--print] [--stored]

Prints a Markdown table. Every search has a process of its own, with one core and a hard limit, and
the same settings for all problems. Every final motion is judged twice: by the authors' own code,
dynobench 0.0.4, and by kinolab's verifier, which is stricter. Runs are written to ``--results`` as
they end: ``--resume`` goes on where it was broken off, ``--print`` only prints the table of it.
``--stored`` replays the benchmark's own solutions instead, and says whether both judgements agree.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from dynobench_study import wheel
from dynobench_study.measuring import (
    Task,
    measure,
    measure_offline,
    offline_sentence,
    prepare_environment,
)
from dynobench_study.problems import chosen, machine_of
from dynobench_study.records import Results, append, read
from dynobench_study.summary import summary
from dynobench_study.tables import LEGEND, table
from gallery import Processes, describe

INTERRUPTED = 130


def missing(problems: list[str], seeds: int, results: Results) -> list[Task]:
    """Return what is not in the results, seed by seed, so that half a table is one too."""
    done = {(run.problem, run.seed) for run in results.runs}
    every = (Task(name, seed) for seed in range(1, seeds + 1) for name in problems)
    return [task for task in every if (task.problem, task.seed) not in done]


def settings_of(options: argparse.Namespace) -> dict[str, Any]:
    """Return what all runs of a file have in common."""
    return {"limit": options.limit, "planner": options.planner or "auto", "jobs": options.jobs}


def measure_all(options: argparse.Namespace, results: Results) -> None:
    """Measure what is missing, and write it as it comes."""
    processes = Processes()
    prepare_environment()
    if not results.circumstances:
        results.circumstances = {**settings_of(options), "on": describe()}
        append(options.results, results.circumstances)
    known = {one.machine for one in results.offline}
    cold = [name for name in options.problems if machine_of(name) not in known]
    tasks = missing(options.problems, options.seeds, results)
    settings = (options.limit, options.planner, options.jobs)
    try:
        for machine in measure_offline(processes.run, options.environments, cold):
            results.offline.append(machine)
            append(options.results, machine)
        for run in measure(processes, options.environments, tasks, *settings):
            results.runs.append(run)
            append(options.results, run)
            print(run, file=sys.stderr, flush=True)
    finally:
        processes.close()  # also where an interrupt came before the first run


def text_of(results: Results, options: argparse.Namespace) -> Iterator[str]:
    """Yield the parts of what is printed."""
    facts, left = results.circumstances, len(missing(options.problems, options.seeds, results))
    limit = float(facts["limit"])
    yield str(facts["on"])
    yield " ".join(_sentences(facts, left, options.seeds))
    own = [run for run in results.runs if run.problem in options.problems]
    yield table(own, results.offline, limit)
    if own:
        yield "\n".join(f"- {line}" for line in summary(own, limit))
    yield offline_sentence(results.offline)
    yield LEGEND


def _sentences(facts: dict[str, Any], left: int, seeds: int) -> Iterator[str]:
    counted = "seed 1" if seeds == 1 else f"seeds 1 to {seeds}"
    yield f"Planner {facts['planner']}, limit {facts['limit']:g} s, {counted}."
    if facts["jobs"] > 1:
        yield f"{facts['jobs']} runs side by side."
    if left:
        yield f"{left} runs are missing."


def replay_all(options: argparse.Namespace) -> int:
    """Replay the stored solutions; return 1 if the two judgements differ."""
    from dynobench_study.stored import replay, report, solutions

    found = []
    for problem, file in solutions(options.environments, options.problems):
        found.append(replay(options.environments, problem, file))
        print(f"{problem}, {file.name}: {found[-1].faults}", file=sys.stderr, flush=True)
    if not found:
        print(f"there are no stored solutions below {options.environments}", file=sys.stderr)
        return 1
    print("\n\n".join([describe(), "\n".join(report(found))]))
    return int(any(one.disagreements for one in found))


def names(text: str) -> list[str]:
    """Return the names of a list that is separated by commas."""
    return [name for name in text.split(",") if name]


def arguments() -> argparse.Namespace:
    """Read the command line."""
    place = wheel.folder()
    parser = argparse.ArgumentParser(description="Plan the problems of dynobench.")
    parser.add_argument("--problems", type=names, metavar="NAME,…", help="default: all 43")
    parser.add_argument("--machines", type=names, metavar="NAME,…", help="default: all 10")
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="seeds 1 to N")
    parser.add_argument("--limit", type=float, default=20.0, metavar="SECONDS", help="of a search")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="runs side by side")
    parser.add_argument("--planner", metavar="NAME", help="default: auto")
    parser.add_argument(
        "--environments",
        type=Path,
        default=place and place / "envs",
        metavar="DIR",
        help="default: those of the package dynobench",
    )
    parser.add_argument("--results", type=Path, default=Path("dynobench.jsonl"), metavar="FILE")
    parser.add_argument("--resume", action="store_true", help="go on with what is in FILE")
    parser.add_argument("--print", action="store_true", help="only print the table of FILE")
    parser.add_argument("--stored", action="store_true", help="replay the stored solutions")
    options = parser.parse_args()
    if min(options.seeds, options.jobs) < 1 or options.limit <= 0:
        parser.error("--seeds, --jobs and --limit must be positive")
    try:
        options.problems = chosen(options.problems, options.machines)
    except ValueError as error:
        parser.error(str(error))
    if not options.print and place is None:
        parser.error(wheel.REASON)
    return options


def refusal(options: argparse.Namespace, results: Results) -> str:
    """Return why a file of results cannot be used, in a sentence; empty if it can."""
    facts, empty = results.circumstances, not results.circumstances
    if options.print:
        return f"{options.results} holds no results. Measure first." if empty else ""
    if not options.resume:
        named = f"{options.results} is there. Give --resume, --print or another --results."
        return named if options.results.exists() else ""
    for key, wanted in settings_of(options).items():
        if not empty and facts[key] != wanted:
            return f"{options.results} has another {key}: {facts[key]}."
    return ""


def main() -> int:
    """Print the table; return 130 if it was interrupted."""
    options, interrupted = arguments(), False
    if options.stored:
        return replay_all(options)
    results = read(options.results)
    if why := refusal(options, results):
        print(why, file=sys.stderr)
        return 2
    if not options.print:
        try:
            measure_all(options, results)
        except (KeyboardInterrupt, InterruptedError):
            interrupted = True
    print("\n\n".join(part for part in text_of(results, options) if part))
    return INTERRUPTED if interrupted else 0


if __name__ == "__main__":
    sys.exit(main())
