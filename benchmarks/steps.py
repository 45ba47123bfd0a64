"""What a step of a tree takes with all that belongs to it, beside what is counted for it as work.

    python benchmarks/steps.py [NAME ...] [--planners NAME,…] [--work SECONDS] [--repeats N]

Each planner grows trees until so much work is done; ``rrt_fast`` ends in the goal. The median of
several repetitions counts, each of which makes the same steps. With ``--python`` the same is done
by another Python, in turn with this one: an older version may be installed there.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from statistics import median
from time import perf_counter
from typing import Any

NAMES = ("submarine_corridor", "crane_factory", "diffdrive_warehouse", "rolling_disk_maze")
HEADINGS = (
    "scenario",
    "planner",
    "steps",
    "a step [us]",
    "counted [us]",
    "the other's [us]",
    "ratio",
)
SEED = 5


def timed(name: str, planner: str, work: float) -> dict[str, float]:
    """Return the number of steps, what each took in [s] and what was counted for it."""
    import kinolab
    from kinolab import planners
    from kinolab.numerics.work import counted_work
    from kinolab.search import Budget

    problem = kinolab.load(name)
    for _ in range(2):  # code is compiled and loaded in the first search
        with counted_work() as counted:
            budget = Budget(work, improve=work, clock=lambda: counted.seconds)
            begun = perf_counter()
            found = planners.make(planner, {}).solve(problem, SEED, budget)
            took = perf_counter() - begun
    steps = found.statistics["propagations"]
    return {"steps": steps, "step": took / steps, "counted": counted.seconds / steps}


def measured(python: str, name: str, planner: str, work: float) -> dict[str, float]:
    """Do that in a process of some Python."""
    command = [python, __file__, name, "--planners", planner, "--work", str(work), "--child"]
    told = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    found: dict[str, float] = json.loads(told.splitlines()[-1])
    return found


def row(name: str, planner: str, given: Any) -> str:
    """Measure one line of the table."""
    own, others = [], []
    for _ in range(given.repeats):
        if given.python:
            others.append(measured(given.python, name, planner, given.work)["step"])
        own.append(measured(sys.executable, name, planner, given.work))
    step, other = median(one["step"] for one in own), median(others) if others else None
    cells = [name, planner, f"{own[0]['steps']:.0f}", f"{1e6 * step:.1f}"]
    cells += [f"{1e6 * own[0]['counted']:.1f}"]
    cells += [f"{1e6 * other:.1f}", f"{other / step:.2f}"] if other else ["–", "–"]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Parse the arguments and measure."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", default=NAMES, metavar="NAME")
    parser.add_argument("--planners", default="kpiece_fast,rrt_fast")
    parser.add_argument("--work", type=float, default=0.5, help="[s], counted")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--python", help="another one, to compare with")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        print(json.dumps(timed(given.names[0], given.planners, given.work)))
        return
    print(f"| {' | '.join(HEADINGS)} |\n|{' --- |' * len(HEADINGS)}")
    for name in given.names:
        for planner in given.planners.split(","):
            print(row(name, planner, given), flush=True)


if __name__ == "__main__":
    main()
