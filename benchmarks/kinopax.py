"""The problems of the GPU planner Kino-PAX, solved on one core of a processor.

    python benchmarks/kinopax.py [--machines NAME,…] [--worlds NAME,…] [--planners NAME,…]
                                 [--seeds N] [--limit SECONDS] [--json FILE]

Prints a Markdown table. A search's time is that of the processor, from the problem to the motion
into the goal, with all that a search sets up for itself; the same settings hold for all problems.
Every motion is then integrated anew and verified as ``plan check`` does it. Boxes and numbers are
those of the authors' repository (MIT licence, beside them in ``kinopax_problems``). Ctrl-C ends it
with a table of what is finished.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import json
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from gallery import describe

import kinolab
from kinolab import planners
from kinolab.problem import PlanningTask
from kinolab.search import Budget, Outcome
from kinolab.simulation.reference import resimulate
from kinolab.verification import verify

FOLDER = Path(__file__).resolve().parent / "kinopax_problems"
MACHINES = {"double_integrator": 1.0, "airplane": 1.0, "quadrotor": 100.0}  # [m] the world's edge
LIMITS = {"airplane": {"pitch": ["-60 deg", "60 deg"]}}
WORLDS = ("trees", "narrow_passage", "house")
PLANNERS = ("auto", "kpiece_fast", "rrt_fast")
START, GOAL = (0.1, 0.08, 0.05), (0.8, 0.95, 0.9)  # of the edge
TOLERANCE, STEP = 0.05, 0.1  # of the edge; [s]
LEAST_EDGE = 1e-3  # of the world's, for boxes without thickness
TARGETS = {"double_integrator": 8.0, "airplane": 8.0, "quadrotor": 25.0}  # [ms] as published
INTERRUPTED = 130


@dataclass(frozen=True)
class Run:
    """How one search ended.

    Attributes:
        machine, world, planner, seed: Which one.
        solved: Whether it found a motion into the goal within the limit.
        cpu: Time of the processor until then in [s], the limit where there is none.
        setup: Of it, in which the search got what it needs.
        complaint: What the verifier refused, where it did.
        duration: Of the motion in [s].
    """

    machine: str
    world: str
    planner: str
    seed: int
    solved: bool
    cpu: float
    setup: float
    complaint: str
    duration: float


def scenario(machine: str, world: str) -> dict[str, Any]:
    """Return a problem of theirs as a scenario."""
    edge = MACHINES[machine]
    span = {axis: [0.0, edge] for axis in "xyz"}
    with (FOLDER / "boxes" / f"{world}.csv").open(encoding="utf-8") as lines:
        corners = np.array([[float(cell) for cell in row] for row in csv.reader(lines) if row])
    corners = edge * np.sort(corners.reshape(-1, 2, 3), axis=1)
    sizes = np.maximum(corners[:, 1] - corners[:, 0], LEAST_EDGE * edge)
    boxes = zip(sizes.tolist(), corners.mean(axis=1).tolist(), strict=True)
    return {
        "schema": 1,
        "title": f"Kino-PAX: {machine} in {world}",
        "system": {"file": f"machines.py:{machine}"},
        "world": {
            "bounds": span,
            "obstacle": [{"box": size, "position": place} for size, place in boxes],
        },
        "bounds": span | LIMITS.get(machine, {}),
        "start": {axis: edge * at for axis, at in zip("xyz", START, strict=True)},
        "goal": {axis: edge * at for axis, at in zip("xyz", GOAL, strict=True)}
        | {"tolerance": edge * TOLERANCE, "norm": "euclidean"},
        "integration": {"step": STEP},
    }


def search(problem: PlanningTask, names: tuple[str, str, str], seed: int, limit: float) -> Run:
    """Search once, and verify what was found.

    Args:
        problem: The problem.
        names: Of machine, world and planner.
        seed: Of the random numbers.
        limit: In [s] of the processor, set-up apart.
    """
    searcher = planners.get(names[-1])()
    budget, begun = Budget(limit, clock=time.process_time, improve=0.0), time.process_time()
    found = searcher.solve(problem, seed, budget)
    setup, cpu = budget.prepared, time.process_time() - begun
    if found.outcome is not Outcome.SOLVED:
        return Run(*names, seed, False, limit, setup, "", 0.0)
    motion = resimulate(problem, found.t, found.u)
    certificate = verify(problem, motion)
    complaint = "; ".join(check.detail for check in certificate.failures)
    return Run(*names, seed, True, cpu, setup, complaint, float(motion.t[-1]))


def measure(options: argparse.Namespace) -> Iterator[Run]:
    """Yield each run as it ends, seed by seed."""
    with contextlib.chdir(FOLDER):  # to which the machines' file is relative
        problems = {
            (machine, world): kinolab.load(scenario(machine, world))
            for machine in options.machines
            for world in options.worlds
        }
    for (machine, world), problem in problems.items():
        for planner in options.planners:  # code is compiled and loaded, and not counted
            search(problem, (machine, world, planner), 0, options.limit)
    for seed in range(1, options.seeds + 1):
        for (machine, world), problem in problems.items():
            for planner in options.planners:
                yield search(problem, (machine, world, planner), seed, options.limit)


def table(runs: Sequence[Run], limit: float) -> str:
    """Return a row for each problem and planner."""
    rows: dict[tuple[str, str, str], list[Run]] = {}
    for run in runs:
        rows.setdefault((run.machine, run.world, run.planner), []).append(run)
    lines = [
        "| machine | world | planner | solved | verified | median [ms] | p90 [ms] | worst [ms] | "
        "set-up of it [ms] | motion [s] | published, below [ms] |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for names, own in rows.items():
        solved = [run for run in own if run.solved]
        times = np.array([run.cpu for run in own])
        spread = (
            f"≥ {1e3 * limit:.0f}" if share >= limit else f"{1e3 * share:.1f}"
            for share in np.quantile(times, [0.5, 0.9, 1.0], method="inverted_cdf")
        )
        verified = sum(not run.complaint for run in solved)
        motion = f"{median(run.duration for run in solved):.1f}" if solved else "–"
        cells = (
            *names, f"{len(solved)}/{len(own)}", f"{verified}/{len(solved)}", *spread,
            f"{1e3 * median(run.setup for run in own):.1f}", motion, f"{TARGETS[names[0]]:.0f}",
        )  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Solve the problems of Kino-PAX on one core.")
    for option, known in (("machines", tuple(MACHINES)), ("worlds", WORLDS)):
        parser.add_argument(
            f"--{option}", type=lambda text: text.split(","), default=list(known),
            metavar="NAME,…", help=f"of {', '.join(known)}; default: all",
        )  # fmt: skip
    parser.add_argument(
        "--planners", type=lambda text: text.split(","), default=list(PLANNERS), metavar="NAME,…"
    )
    parser.add_argument("--seeds", type=int, default=50, metavar="N", help="seeds 1 to N")
    parser.add_argument("--limit", type=float, default=20.0, metavar="SECONDS")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all runs to a file")
    options = parser.parse_args()
    for option, known in (("machines", MACHINES), ("worlds", WORLDS)):
        for name in getattr(options, option):
            if name not in known:
                parser.error(f"--{option}: nothing is called {name}; known: {', '.join(known)}")
    for name in options.planners:
        if name not in planners.names():
            parser.error(f"--planners: kinolab has no planner {name}")
    if options.seeds < 1 or options.limit <= 0:
        parser.error("--seeds and --limit must be positive")
    return options


def main() -> int:
    """Print the table; return 130 if it was interrupted."""
    options, runs, code = arguments(), list[Run](), 0
    try:
        for run in measure(options):
            runs.append(run)
            print(run, file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        code = INTERRUPTED
    print(f"{describe()}\n\n{table(runs, options.limit)}")
    if options.json:
        options.json.write_text(json.dumps([asdict(run) for run in runs], indent=1) + "\n")
    return code


if __name__ == "__main__":
    sys.exit(main())
