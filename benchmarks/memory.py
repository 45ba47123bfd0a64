"""How much memory a process keeps from solves that are over, planner by planner.

    python benchmarks/memory.py [NAME ...] [--solves 1000] [--warm-up 20] [--changed WHAT]
                                [--json FILE]

Every planner solves one small problem with many seeds in one process; with ``--changed`` each time
another problem, of which the start, the goal, a parameter of the machine, an obstacle or the limits
are a little off. For parameters and limits, ``KINOLAB_CACHE`` should name a new folder: what is in
the cache is not made anew. What libraries set up once is there after the warm-up; what grows after
it is kept for nothing. A leak grows all the time, so that the growth is shown by quarters too: an
allocator that asks for more in one of them is none.
"""

from __future__ import annotations

import argparse
import ctypes
import gc
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from os import getpid, sysconf
from pathlib import Path
from typing import Any

TABLE = """\
schema = 1
title = "A coin on a table"

[system]
name = "rolling_disk"

[world]
bounds = { x = [-5, 5], y = [-5, 5] }
ground = "plane"

[[world.obstacle]]
box = [0.1, 4.0, 1.0]
position = [3.0, 0.0, 0.5]

[start]
x = -1.0

[goal]
x = 0.0
y = 0.0
tolerance = 0.5
"""

QUARTERS = 4
ITERATIONS = 5000  # of one solve, at most
OFF = 1e-5  # [m], by which a changed problem differs from the one before
CHANGES: dict[str, Callable[[float], dict[str, Any]]] = {
    "start": lambda off: {"start.x": -1.0 + off},
    "goal": lambda off: {"goal.tolerance": 0.5 + off},
    "parameter": lambda off: {"system.parameters": {"R": 0.25 + off}},
    "obstacle": lambda off: {"world.obstacle.1.position": [3.0, off, 0.5]},
    "bounds": lambda off: {"world.bounds.x": [-5.0, 5.0 + off]},
    "limits": lambda off: {"bounds.drive": [-0.5 - off, 0.5]},
}
HEADINGS = ("planner", "solves", "growth, MB", "by quarters, MB", "MB per 1000 at most")


@dataclass(frozen=True)
class Growth:
    """What one planner keeps.

    Attributes:
        planner: Its name.
        solves: After the warm-up.
        solved: How many of them ended with a verified plan.
        quarters: Growth of the resident memory in each quarter of them, in [MB].
    """

    planner: str
    solves: int
    solved: int
    quarters: tuple[float, ...]

    @property
    def total(self) -> float:
        """Growth over all solves, in [MB]."""
        return sum(self.quarters)

    @property
    def steady(self) -> float:
        """What a leak explains of it at most: the least quarter's growth per 1000 solves."""
        return max(min(self.quarters), 0.0) * QUARTERS / self.solves * 1000

    def __str__(self) -> str:
        quarters = " ".join(f"{megabytes:+.2f}" for megabytes in self.quarters)
        cells = (f"{self.solves} ({self.solved} solved)", f"{self.total:+.2f}", quarters)
        return f"| {' | '.join((self.planner, *cells, f'{self.steady:.2f}'))} |"


def resident() -> float:
    """Return the memory of this process that is in use, in [MB]; the allocator gives back first."""
    gc.collect()
    if trim := getattr(ctypes.CDLL(None), "malloc_trim", None):  # of glibc
        trim(0)
    statistics = Path("/proc/self/statm")
    if statistics.exists():
        return int(statistics.read_text().split()[1]) * sysconf("SC_PAGESIZE") / 1e6
    listed = subprocess.run(
        ["ps", "-o", "rss=", "-p", str(getpid())], capture_output=True, text=True, check=True
    )
    return int(listed.stdout) * 1024 / 1e6


def measure(planner: str, solves: int, warm_up: int, changed: str | None = None) -> Growth:
    """Solve the small problem, or changed ones, with seeds 0, 1, …"""
    import kinolab

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.toml"
        path.write_text(TABLE, encoding="utf-8")
        problem = kinolab.load(path)
    seeds, solved = iter(range(warm_up + solves)), 0
    marks: list[float] = []
    for count in (warm_up, *shares(solves)):
        for _ in range(count):
            seed = next(seeds)
            own = problem.replace(CHANGES[changed](OFF * seed)) if changed else problem
            found = own.solve(planner, seed, max_iterations=ITERATIONS, optimize=False)
            solved += bool(marks) and found.status == "solved"
        marks.append(resident())
    quarters = tuple(after - before for before, after in pairwise(marks))
    return Growth(planner, solves, solved, quarters)


def shares(solves: int) -> Iterator[int]:
    """Yield how many solves each quarter has."""
    for k in range(QUARTERS):
        yield solves * (k + 1) // QUARTERS - solves * k // QUARTERS


def arguments() -> argparse.Namespace:
    """Read the command line."""
    from kinolab import planners

    parser = argparse.ArgumentParser(description="Measure what solves leave in memory.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="planners; default: all")
    parser.add_argument("--solves", type=int, default=1000, metavar="N", help="after the warm-up")
    parser.add_argument("--warm-up", type=int, default=20, metavar="N", help="solves before")
    parser.add_argument("--changed", choices=tuple(CHANGES), help="what differs each time")
    parser.add_argument("--json", metavar="FILE", help="write the figures to a file")
    options = parser.parse_args()
    unknown = set(options.names) - set(planners.names())
    if unknown:
        parser.error(f"no planner is called {', '.join(sorted(unknown))}")
    if options.solves < QUARTERS or options.warm_up < 0:
        parser.error(f"--solves must be {QUARTERS} or more, --warm-up not negative")
    options.names = options.names or planners.names()
    return options


def table(growths: Sequence[Growth]) -> str:
    """Return the figures as a Markdown table."""
    rows = [f"| {' | '.join(HEADINGS)} |", f"|{' --- |' * len(HEADINGS)}"]
    return "\n".join([*rows, *map(str, growths)])


def main() -> int:
    """Print the table."""
    options = arguments()
    growths = []
    for name in options.names:
        growths.append(measure(name, options.solves, options.warm_up, options.changed))
        print(growths[-1], file=sys.stderr)
    print(table(growths))
    if options.json:
        figures = [{**asdict(growth), "steady": growth.steady} for growth in growths]
        Path(options.json).write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
