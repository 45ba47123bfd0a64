"""How soon `flat_connect` has motions, and how long they are.

    python benchmarks/flat.py [--problems NAME,…] [--seeds N] [--rounds N] [--shortcuts N]

Prints a Markdown table of first motions, and of those that the planner has after its shortcuts: of
Kino-PAX's double integrator in its three worlds, and of the scenarios whose machines can be planned
for in flat outputs. The time of a search is that of the processor,
without what it sets up, which stands beside it. Every motion is integrated anew and verified as
``plan check`` does it. Durations are those of the planner's own motions, which nothing improves,
also as multiples of the shortest known (`best_known.toml`). Seeds are 11 to 10 + N.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import kinopax
import numpy as np
from gallery import describe

import kinolab
from kinolab import planners
from kinolab.problem import PlanningTask
from kinolab.search import Budget, Outcome
from kinolab.simulation.reference import resimulate
from kinolab.verification import verify

BEST = Path(__file__).resolve().parent / "best_known.toml"
POINTS = tuple(f"double_integrator/{world}" for world in kinopax.WORLDS)
SCENARIOS = (
    *("panda_shelves", "rolling_disk_maze", "diffdrive_trap", "diffdrive_warehouse"),
    "vehicle_parking",
)
FIRST_SEED, LIMIT = 11, 20.0  # LIMIT: [s] of the processor


@dataclass(frozen=True)
class Found:
    """How one search ended: times in [s], the duration nan where it found nothing."""

    search: float
    setup: float
    duration: float
    complaint: str


def load(name: str) -> PlanningTask:
    """Return a problem by its name."""
    machine, _, world = name.partition("/")
    if not world:
        return kinolab.load(name)
    with contextlib.chdir(kinopax.FOLDER):
        return kinolab.load(kinopax.scenario(machine, world))


def search(
    problem: PlanningTask, seed: int, settings: dict[str, int], improve: float | None
) -> Found:
    """Search once, for the first motion where ``improve`` is 0, and verify what was found."""
    budget = Budget(LIMIT, clock=time.process_time, improve=improve)
    begun = time.process_time()
    found = planners.make("flat_connect", settings).solve(problem, seed, budget)
    taken = time.process_time() - begun - budget.prepared
    if found.outcome is not Outcome.SOLVED:
        return Found(taken, budget.prepared, np.nan, "")
    motion = resimulate(problem, found.t, found.u)
    failed = "; ".join(check.detail for check in verify(problem, motion).failures)
    return Found(taken, budget.prepared, float(motion.t[-1]), failed)


def cells(runs: Sequence[Found], best: float | None) -> tuple[str, ...]:
    """Return what a row says of first motions, or of later ones."""
    solved = [run for run in runs if np.isfinite(run.duration)]
    verified = sum(not run.complaint for run in solved)
    times = np.quantile([1e3 * run.search for run in runs], [0.5, 0.9], method="inverted_cdf")
    duration = median(run.duration for run in solved) if solved else np.nan
    return (
        f"{len(solved)}/{len(runs)}", f"{verified}/{len(solved)}",
        *(f"{one:.1f}" for one in times), f"{duration:.2f}",
        "–" if best is None else f"{duration / best:.2f}",
    )  # fmt: skip


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Measure the planner flat_connect.")
    known = (*POINTS, *SCENARIOS)
    parser.add_argument(
        "--problems", type=lambda text: text.split(","), default=list(known), metavar="NAME,…"
    )
    parser.add_argument("--seeds", type=int, default=20, metavar="N")
    parser.add_argument("--rounds", type=int, default=1, metavar="N")
    parser.add_argument("--shortcuts", type=int, default=400, metavar="N")
    options = parser.parse_args()
    settings = {"rounds": options.rounds, "shortcuts": options.shortcuts}
    best = tomllib.loads(BEST.read_text(encoding="utf-8"))
    columns = ("solved", "verified", "median [ms]", "p90 [ms]", "motion [s]", "/ best known")
    heads = (
        "problem",
        "set-up [ms]",
        *(f"{when} {c}" for when in ("first:", "then:") for c in columns),
    )
    print(f"{describe()}, {settings}\n\n| {' | '.join(heads)} |\n|{' --- |' * len(heads)}")
    for name in options.problems:
        problem = load(name)
        search(problem, 0, settings, 0.0)  # code is compiled and loaded
        seeds = range(FIRST_SEED, FIRST_SEED + options.seeds)
        both = [
            [search(problem, seed, settings, improve) for seed in seeds] for improve in (0.0, None)
        ]
        setup = f"{1e3 * median(run.setup for run in both[0]):.1f}"
        told = [cell for runs in both for cell in cells(runs, best.get(name))]
        print(f"| {' | '.join((name, setup, *told))} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
