"""Planners against scenarios: who solves what, how fast, and how long the motions are.

    python benchmarks/matrix.py [--planners NAME,…] [--scenarios NAME,…] [--all] [--seeds N]
                                [--time-limit SECONDS] [--jobs N] [--json FILE] [--keep DIR]

Prints a Markdown table. Without ``--all`` only the pairs in ``MEANT`` are run: what each planner is
there for. Every plan is searched for in a process of its own, with the planner's and the
scenario's settings as they stand, and judged by ``plan check`` in another.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from argparse import Namespace
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from statistics import median

from gallery import Case, Processes, Run, describe, plan, write_json

TREES = ("rrt", "est", "kpiece", "syclop_rrt", "syclop_est")
FOR_TREES = ("rolling_disk_maze", "vehicle_parking", "snakeboard_park", "submarine_corridor")
FOR_ROADMAPS = ("vehicle_parking", "diffdrive_warehouse", "crane_factory")
FOR_FIELDS = ("diffdrive_warehouse", "crane_factory", "submarine_corridor", "diffdrive_trap")
MEANT: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(TREES, FOR_TREES),
    "prm": FOR_ROADMAPS,
    "prm_geometric": FOR_ROADMAPS,
    "potential_field": FOR_FIELDS,
}
LEGEND = """\
- Each cell: solved and checked runs of all, median time of the search, median duration of the
  motions found. A run without a verified plan counts as the time limit, and ≥ marks a median that
  is one. *n checked* follows where `plan check` did not confirm every solved run.
- An empty cell was not run: the planner is not meant for that scenario."""


@dataclass(frozen=True)
class Cell:
    """A planner and a scenario, by their names."""

    planner: str
    scenario: str


def cells(options: Namespace) -> list[Cell]:
    """Return the pairs to be run, planner by planner."""
    planners = options.planners.split(",") if options.planners else list(MEANT)
    chosen = options.scenarios.split(",") if options.scenarios else None
    found = []
    for planner in planners:
        meant = list(every_scenario()) if options.all else MEANT.get(planner, ())
        found += [Cell(planner, name) for name in meant if chosen is None or name in chosen]
    return found


def every_scenario() -> list[str]:
    """Return the names of all built-in scenarios."""
    from kinolab.scenario import builtin_scenarios

    return list(builtin_scenarios())


def run_all(todo: Sequence[Cell], options: Namespace) -> dict[Cell, list[Run]]:
    """Run every cell with every seed; return what was finished before Ctrl-C."""
    processes, finished = Processes(), {cell: list[Run]() for cell in todo}
    with ThreadPoolExecutor(options.jobs) as pool:
        futures = {}
        for seed in range(1, options.seeds + 1):  # seed by seed, so that half a table is one too
            for cell in todo:
                keep = f"{options.keep}/{cell.planner}"
                own = Namespace(**{**vars(options), "planner": cell.planner, "keep": keep})
                case = Case(cell.scenario, "–", cell.planner)
                futures[pool.submit(plan, processes, case, seed, own)] = cell
        try:
            for future in as_completed(futures):
                finished[futures[future]].append(future.result())
                print(f"{futures[future].planner}: {future.result()}", file=sys.stderr, flush=True)
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)
            processes.close()
    return finished


def text_of(runs: Sequence[Run], limit: float) -> str:
    """Return the figures of one cell as text."""
    if not runs:
        return ""
    solved = [run for run in runs if run.solved]
    checked = sum(run.check_code == 0 for run in solved)
    times = sorted([run.search for run in solved if run.search is not None])
    times += [limit] * (len(runs) - len(times))
    unsure = "≥ " if len(solved) <= len(runs) // 2 else ""
    durations = [run.duration for run in solved if run.duration is not None]
    parts = [f"{len(solved)}/{len(runs)}", f"{unsure}{median(times):.1f} s"]
    parts += [f"{median(durations):.0f} s"] if durations else []
    parts += [f"{checked} checked"] if checked < len(solved) else []
    return ", ".join(parts)


def table(results: dict[Cell, list[Run]], limit: float) -> str:
    """Return the matrix as Markdown: planners down, scenarios across."""
    planners = list(dict.fromkeys(cell.planner for cell in results))
    scenarios = sorted({cell.scenario for cell in results})
    rows = [["planner", *scenarios], ["---"] * (len(scenarios) + 1)]
    for planner in planners:
        own = [results.get(Cell(planner, scenario), []) for scenario in scenarios]
        rows.append([planner, *(text_of(runs, limit) for runs in own)])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def arguments() -> Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Plan scenarios with every planner.")
    parser.add_argument("--planners", metavar="NAME,…", help="default: all that are meant")
    parser.add_argument("--scenarios", metavar="NAME,…", help="default: all that are meant")
    parser.add_argument("--all", action="store_true", help="every planner on every scenario")
    parser.add_argument("--seeds", type=int, default=5, metavar="N", help="seeds 1 to N")
    parser.add_argument("--time-limit", type=float, default=120.0, metavar="SECONDS")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="runs side by side")
    parser.add_argument("--json", metavar="FILE", help="write every run to a file")
    parser.add_argument("--keep", metavar="DIR", help="keep the folders of the runs in DIR")
    options = parser.parse_args()
    if min(options.seeds, options.jobs) < 1 or options.time_limit <= 0:
        parser.error("--seeds, --jobs and --time-limit must be positive")
    return options


def main() -> int:
    """Print the matrix; return 1 if a cell is not solved at every seed."""
    options = arguments()
    todo = cells(options)
    with tempfile.TemporaryDirectory() as folder:
        options.keep = options.keep or folder
        results = run_all(todo, options)
    beside = f", {options.jobs} runs side by side" if options.jobs > 1 else ""
    text = f"Search limit {options.time_limit:g} s, seeds 1 to {options.seeds}{beside}."
    print(f"{describe()}\n\n{text}\n\n{table(results, options.time_limit)}\n\n{LEGEND}")
    if options.json:
        write_json(options.json, options, [run for runs in results.values() for run in runs], text)
    everything = all(
        run.solved and run.check_code == 0 for runs in results.values() for run in runs
    )
    return 0 if everything else 1


if __name__ == "__main__":
    sys.exit(main())
