"""How long searches go on after their time is over.

    python benchmarks/overrun.py [SCENARIO ...] [--planners NAME,…] [--limit 0.5] [--seeds 3]
                                 [--json FILE]

Every planner searches on every scenario, each pair in a process of its own, so that the first
search finds nothing loaded. Each seed searches twice: once the limit and what goes beyond it are
seconds of the processor, once they are seconds on the clock. A search that solves its problem
within the limit is made again with half the time that it took.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from gallery import describe

from kinolab.search import AbstractPlanner, Budget, Outcome
from kinolab.solve.attempt import old_objects_left_alone

HALVINGS = 6  # of a limit, where a search keeps solving its problem
PATIENCE = 600  # [s] for a pair


@dataclass(frozen=True)
class Overrun:
    """The largest figures of all seeds.

    Attributes:
        planner: Its name.
        scenario: Its name.
        cpu: Time beyond the limit in [s] of the processor; None where no search came to its limit.
        wall: The same on the clock, with the limit on the clock.
        longest: Time of the processor between two looks at the clock at most, in [s].
    """

    planner: str
    scenario: str
    cpu: float | None
    wall: float | None
    longest: float

    def __str__(self) -> str:
        if self.cpu is None or self.wall is None:
            return "–"
        return f"{1e3 * self.cpu:.0f} / {1e3 * self.wall:.0f}"


class Watched(Budget):
    """A budget that knows how long it was not asked; preparation does not count.

    Attributes:
        longest: In the unit of its clock.
    """

    longest = asked = 0.0

    def restart(self) -> None:
        """Begin to count the time."""
        super().restart()
        self.asked = 0.0

    def expired(self) -> bool:
        """Say whether the time is over."""
        self.note()
        return super().expired()

    def note(self) -> None:
        """Note the time since it was asked last."""
        now = self.elapsed
        self.longest, self.asked = max(self.longest, now - self.asked), now


def search(
    planner: AbstractPlanner, problem: Any, seed: int, limit: float, clock: Callable[[], float]
) -> tuple[float | None, float]:
    """Return by how much a search exceeds its limit, if it does, and its longest piece."""
    longest = 0.0
    for _ in range(HALVINGS):
        budget = Watched(limit, clock=clock)
        with old_objects_left_alone():
            found = planner.solve(problem, seed, budget)
        budget.note()
        longest, taken = max(longest, budget.longest), budget.elapsed
        if taken > limit:
            return taken - limit, longest
        if found.outcome is not Outcome.SOLVED:
            break  # it knows nothing more to try
        limit = taken / 2
    return None, longest


def measure(planner: str, scenario: str, limit: float, seeds: int) -> Overrun:
    """Search in this process."""
    import kinolab.loading
    from kinolab import planners

    problem = kinolab.load(scenario)
    problem.check_endpoints()
    searcher, longest = planners.make(planner, {}), 0.0
    cpu, wall = list[float](), list[float]()
    for seed in range(1, seeds + 1):
        for clock, found in ((time.process_time, cpu), (time.monotonic, wall)):
            beyond, piece = search(searcher, problem, seed, limit, clock)
            if beyond is not None:
                found.append(beyond)
            if clock is time.process_time:
                longest = max(longest, piece)
    return Overrun(planner, scenario, max(cpu, default=None), max(wall, default=None), longest)


def measured(planner: str, scenario: str, options: argparse.Namespace) -> Overrun:
    """Search in a process of its own."""
    limits = ["--limit", str(options.limit), "--seeds", str(options.seeds)]
    done = subprocess.run(
        [sys.executable, __file__, scenario, "--planners", planner, *limits, "--here"],
        capture_output=True,
        text=True,
        check=True,
        timeout=PATIENCE,
    )
    return Overrun(**json.loads(done.stdout.splitlines()[-1]))


def table(found: Sequence[Overrun]) -> str:
    """Return the figures as a Markdown table, planners by scenarios."""
    scenarios = list(dict.fromkeys(one.scenario for one in found))
    heads = ["planner", *scenarios, "longest piece, ms"]
    lines = [f"| {' | '.join(heads)} |", f"|{' --- |' * len(heads)}"]
    for planner in dict.fromkeys(one.planner for one in found):
        row = {one.scenario: one for one in found if one.planner == planner}
        cells = [str(row[name]) if name in row else "" for name in scenarios]
        worst = max(row.values(), key=lambda one: one.longest)
        lines.append(
            f"| {planner} | {' | '.join(cells)} | {1e3 * worst.longest:.0f}, {worst.scenario} |"
        )
    return "\n".join(lines)


def arguments() -> argparse.Namespace:
    """Read the command line."""
    from kinolab import planners
    from kinolab.scenario import builtin_scenarios

    parser = argparse.ArgumentParser(description="Measure how far searches exceed their limits.")
    parser.add_argument(
        "scenarios", nargs="*", default=list(builtin_scenarios()), metavar="SCENARIO"
    )
    names = parser.add_argument("--planners", metavar="NAME,…", help="default: all")
    parser.add_argument("--limit", type=float, default=0.5, metavar="SECONDS")
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="seeds 1 to N")
    parser.add_argument("--json", metavar="FILE", help="write the figures to a file")
    parser.add_argument("--here", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    options.planners = options.planners.split(",") if options.planners else list(planners.names())
    unknown = set(options.planners) - set(planners.names())
    if unknown:
        parser.error(
            f"{names.option_strings[0]}: no planner is called {', '.join(sorted(unknown))}"
        )
    if options.limit <= 0 or options.seeds < 1:
        parser.error("--limit and --seeds must be positive")
    return options


def main() -> None:
    """Measure and print."""
    options = arguments()
    if options.here:
        found = measure(options.planners[0], options.scenarios[0], options.limit, options.seeds)
        print(json.dumps(asdict(found)))
        return
    all_found = []
    for planner in options.planners:
        for scenario in options.scenarios:
            all_found.append(measured(planner, scenario, options))
            print(all_found[-1], planner, scenario, all_found[-1].longest, file=sys.stderr)
    command = f"`python benchmarks/{' '.join([Path(__file__).name, *sys.argv[1:]])}`"
    text = f"Search limit {options.limit:g} s, seeds 1 to {options.seeds}."
    print("\n\n".join([command, f"{describe()}. {text}", table(all_found)]))
    if options.json:
        figures = [asdict(one) for one in all_found]
        Path(options.json).write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
