"""How much memory a process keeps from solves that are over, planner by planner.

    python benchmarks/memory.py [NAME ...] [--solves 1000] [--warm-up 20] [--json FILE]

Every planner solves one small problem with many seeds in one process. What libraries set up once is
there after the warm-up; what grows after it is kept for nothing. A leak grows all the time, so that
the growth is shown by quarters too: an allocator that asks for more in one of them is none.
"""

from __future__ import annotations

import argparse
import gc
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from os import getpid, sysconf
from pathlib import Path

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
    """Return the memory of this process that is in use, in [MB]."""
    statistics = Path("/proc/self/statm")
    if statistics.exists():
        return int(statistics.read_text().split()[1]) * sysconf("SC_PAGESIZE") / 1e6
    listed = subprocess.run(
        ["ps", "-o", "rss=", "-p", str(getpid())], capture_output=True, text=True, check=True
    )
    return int(listed.stdout) * 1024 / 1e6


def measure(planner: str, solves: int, warm_up: int) -> Growth:
    """Solve the small problem with seeds 0, 1, …"""
    import kinolab

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.toml"
        path.write_text(TABLE, encoding="utf-8")
        problem = kinolab.load(path)
    seeds, solved = iter(range(warm_up + solves)), 0
    marks = []
    for count in (warm_up, *shares(solves)):
        for _ in range(count):
            found = problem.solve(
                planner=planner, seed=next(seeds), max_iterations=ITERATIONS, optimize=False
            )
            solved += bool(marks) and found.status == "solved"
        gc.collect()
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
        growths.append(measure(name, options.solves, options.warm_up))
        print(growths[-1], file=sys.stderr)
    print(table(growths))
    if options.json:
        figures = [{**asdict(growth), "steady": growth.steady} for growth in growths]
        Path(options.json).write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
