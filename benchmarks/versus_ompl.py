"""kinolab's compiled planners beside OMPL's control planners in C++, on two problems.

    python benchmarks/versus_ompl.py [--parts NAME,…] [--problems NAME,…] [--planners NAME,…]
                                     [--ompl NAME,…] [--seeds N] [--limit SECONDS] [--repeats N]
                                     [--threads N] [--build DIR] [--json FILE]
                                     [--objective effort]

Prints Markdown tables. Searches run one at a time, seed by seed, OMPL's and kinolab's in turn, so
that both see the same machine. Every motion that either side finds is judged alike: re-simulated
from its inputs, and looked at by exact FCL at the knots and at four places within every step.
With an objective OMPL's SST and kinolab's planners search for the whole limit, and what their
motions cost is compared. Ctrl-C ends it with tables of what is finished. OMPL is built with CMake
from ``ompl_cpp``; where that cannot be done, it says what to install.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from gallery import describe
from versus import cpp, ours, tables
from versus.beginning import Beginning, begin
from versus.costs import Cost, cheapest, costs
from versus.growing import Growth, grow
from versus.runs import OMPL, OMPL_PLANNERS, PROBLEMS, Entrant, Run, entrants
from versus.together import Throughput, run_together
from versus.verdict import Judge

PARTS = ("searches", "growth", "compilation", "together")
NEED_OMPL = ("searches", "growth", "costs")
PLANNERS = ("rrt_fast", "sst", "ao_rrt", "kpiece_fast")
INTERRUPTED = 130  # the exit code


@dataclass
class Results:
    """What is finished."""

    runs: list[Run] = field(default_factory=list)
    growths: list[Growth] = field(default_factory=list)
    beginnings: list[Beginning] = field(default_factory=list)
    throughputs: list[Throughput] = field(default_factory=list)
    costs: list[Cost] = field(default_factory=list)


def searched(baseline: cpp.Baseline, options: argparse.Namespace) -> Iterator[Run]:
    """Search with everyone and every seed; yield each run as it ends."""
    everyone = entrants(options.ompl, options.planners, options.threads)
    judges = {name: Judge(ours.load(name)) for name in options.problems}
    for problem, judge in judges.items():
        for entrant in everyone:
            if entrant.side != OMPL:  # code is compiled and loaded, and not counted
                ours.search(problem, judge, entrant, 0, options.limit)
    for seed in range(1, options.seeds + 1):
        for problem, judge in judges.items():
            for entrant in everyone:
                yield _search(baseline, problem, judge, entrant, seed, options.limit)


def _search(
    baseline: cpp.Baseline, problem: str, judge: Judge, entrant: Entrant, seed: int, limit: float
) -> Run:
    side = baseline.search if entrant.side == OMPL else ours.search
    return side(problem, judge, entrant, seed, limit)


def measure(baseline: cpp.Baseline | None, options: argparse.Namespace, results: Results) -> None:
    """Measure the parts that were asked for, and keep what is finished."""
    repeats, limit, problems = options.repeats, options.limit, options.problems
    parts: dict[str, Callable[[], tuple[Iterable[Any], list[Any]]]] = {
        "compilation": lambda: (begin(problems, options.planners, repeats), results.beginnings),
        "together": lambda: (run_together(problems, repeats), results.throughputs),
    }
    if baseline is not None:
        seeds, built = range(1, repeats + 1), baseline
        parts["growth"] = lambda: (grow(built, problems, seeds, limit), results.growths)
        parts["costs"] = lambda: (
            cheapest(built, problems, options.planners, options.seeds, limit),
            results.costs,
        )
        parts["searches"] = lambda: (searched(built, options), results.runs)
    for part in options.parts:
        found, kept = parts[part]()
        for one in found:
            kept.append(one)
            print(one, file=sys.stderr, flush=True)


def report(results: Results, options: argparse.Namespace) -> Iterator[str]:
    """Yield the tables of what was measured, each below its name."""
    if results.runs:
        yield "The first motion into the goal:"
        yield tables.searches(results.runs, options.limit)
        yield from tables.refused(results.runs)
        yield "OMPL's time over kinolab's, of the processor, set-up and verdict included:"
        yield tables.ratios(results.runs, options.limit)
    if results.costs:
        yield "What the best motion costs, by effort and a tenth a second:"
        yield costs(results.costs)
    if results.growths:
        yield "Propagations per second by nodes of the tree:"
        yield tables.rates(results.growths)
        yield "Memory:"
        yield tables.memory(results.growths)
    if results.beginnings:
        yield "Compilation:"
        yield tables.beginnings(results.beginnings)
    if results.throughputs:
        yield "Two searches at once:"
        yield tables.throughputs(results.throughputs)


def circumstances(options: argparse.Namespace, results: Results, *, interrupted: bool) -> str:
    """Return how the figures were taken, as sentences."""
    sentences = []
    if {"searches", "costs"} & set(options.parts):
        text = f"Search limit {options.limit:g} s of CPU time, seeds 1 to {options.seeds}"
        sentences.append(f"{text}, one search at a time.")
    if set(options.parts) - {"searches", "costs"}:
        sentences.append(f"Other figures are medians of {options.repeats}.")
    if interrupted:
        sentences.append(f"Interrupted after {len(results.runs)} searches.")
    return " ".join(sentences)


def names(text: str) -> list[str]:
    """Return the names of a list that is separated by commas."""
    return [name for name in text.split(",") if name]


def arguments() -> argparse.Namespace:
    """Read the command line."""
    from kinolab import planners

    parser = argparse.ArgumentParser(description="Compare kinolab with OMPL in C++.")
    for option, known in (("parts", PARTS), ("problems", PROBLEMS), ("ompl", OMPL_PLANNERS)):
        shown = f"of {', '.join(known)}; default: all"
        parser.add_argument(
            f"--{option}", type=names, default=list(known), metavar="NAME,…", help=shown
        )
    parser.add_argument("--planners", type=names, metavar="NAME,…", help="kinolab's; default: all")
    parser.add_argument("--seeds", type=int, default=200, metavar="N", help="seeds 1 to N")
    parser.add_argument("--limit", type=float, default=20.0, metavar="SECONDS", help="CPU time")
    parser.add_argument("--repeats", type=int, default=5, metavar="N", help="of the other parts")
    parser.add_argument("--threads", type=int, default=1, metavar="N", help="that grow a tree, too")
    parser.add_argument("--build", type=Path, metavar="DIR", help="where OMPL's side is built")
    parser.add_argument("--objective", choices=["effort"], help="compare costs, and nothing else")
    parser.add_argument("--json", metavar="FILE", help="write all figures to a file")
    options = parser.parse_args()
    for option, known in (("parts", PARTS), ("problems", PROBLEMS), ("ompl", OMPL_PLANNERS)):
        unknown = set(getattr(options, option)) - set(known)
        if unknown:
            parser.error(f"--{option}: nothing is called {', '.join(sorted(unknown))}")
    if min(options.seeds, options.repeats, options.threads) < 1 or options.limit <= 0:
        parser.error("--seeds, --repeats, --threads and --limit must be positive")
    if options.objective:
        options.parts = ["costs"]
    asked = options.planners or list(PLANNERS)
    options.planners = [name for name in asked if name in planners.names()]
    for name in asked:
        if name not in options.planners:
            print(f"skipped: kinolab has no planner {name}", file=sys.stderr)
    return options


def main() -> int:
    """Print the tables; return 130 if it was interrupted, 1 if OMPL cannot be built."""
    options, results, interrupted = arguments(), Results(), False
    try:
        needed = set(options.parts) & set(NEED_OMPL)
        baseline = cpp.build(options.build) if needed else None
    except cpp.MissingError as error:
        print(error, file=sys.stderr)
        return 1
    try:
        measure(baseline, options, results)
    except KeyboardInterrupt:
        interrupted = True
    except (subprocess.SubprocessError, RuntimeError) as error:  # a process that crashed or hangs
        print(error, file=sys.stderr)
        interrupted = True
    machine = describe() + (f"\n\nIn C++: {baseline.version}" if baseline else "")
    text = circumstances(options, results, interrupted=interrupted)
    command = f"`python benchmarks/{' '.join([Path(__file__).name, *sys.argv[1:]])}`"
    print("\n\n".join([command, machine, text, *report(results, options)]))
    if options.json:
        content = {"machine": machine.splitlines(), "circumstances": text, **asdict(results)}
        Path(options.json).write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    return INTERRUPTED if interrupted else 0


if __name__ == "__main__":
    sys.exit(main())
