"""What a Dask cluster costs a study: throughput against plain processes, and what travels.

    python benchmarks/study_throughput.py [--workers 8] [--runs 320] [--repeats 3] [--parts NAME,…]

Prints Markdown tables. Parts:

- ``waiting``: runs that wait 0.5 s, so that 8 workers can be busy on any computer; the ideal is
  known: 16 runs a second.
- ``searching``: searches of about 0.5 s of processor time each; the same runs, in turn, with as
  many processes and with as many Dask workers.
- ``nothing``: orders that do nothing: what a run costs a scheduler.
- ``sizes``: bytes of what travels: an order, an answer, the files of each built-in scenario.

Start-up of processes and clusters is timed apart.
"""

from __future__ import annotations

import argparse
import pickle
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from statistics import median

from gallery import describe
from waiting_order import WaitingOrder

from kinolab.loading import load
from kinolab.scenario import builtin_scenarios
from kinolab.studies.dask_engine import DaskEngine
from kinolab.studies.engine import AbstractEngine, LocalEngine
from kinolab.studies.orders import Answer, SearchOrder, WorkOrder
from kinolab.studies.problem_files import ProblemFiles, files_of

SPAN = 0.5  # [s] of a run
SEARCHED = ("falling_disk_slalom", "rrt_fast")


def timed(
    make: Callable[[], AbstractEngine], orders: Sequence[WorkOrder]
) -> tuple[float, float, list[Answer]]:
    """Return the seconds of start-up and of all orders, and their answers."""
    begun = time.perf_counter()
    with make() as engine:
        first = orders[: engine.workers]  # starts every worker's process, and warms it
        for _ in engine.answers(iter(first)):
            pass
        started = time.perf_counter()
        answers = list(engine.answers(iter(orders)))
        ended = time.perf_counter()
    return started - begun, ended - started, answers


def compared(
    orders: Sequence[WorkOrder], files: ProblemFiles, options: argparse.Namespace
) -> Iterator[str]:
    """Yield table rows: plain processes and Dask workers in turn."""
    with tempfile.TemporaryDirectory() as root:
        files.written(Path(root))
        sides: dict[str, Callable[[], AbstractEngine]] = {
            "processes": lambda: LocalEngine(options.workers, Path(root)),
            "Dask": lambda: DaskEngine(f"local:{options.workers}", [files]),
        }
        seconds: dict[str, list[float]] = {name: [] for name in sides}
        starts: dict[str, list[float]] = {name: [] for name in sides}
        for _ in range(options.repeats):
            for name, make in sides.items():
                start, took, _ = timed(make, orders)
                seconds[name].append(took)
                starts[name].append(start)
                print(name, f"{start:.1f} s, {took:.2f} s", file=sys.stderr, flush=True)
    for name in sides:
        rate = len(orders) / median(seconds[name])
        share = median(seconds["processes"]) / median(seconds[name])
        yield (
            f"| {name} | {median(starts[name]):.1f} | {median(seconds[name]):.2f} "
            f"({min(seconds[name]):.2f} to {max(seconds[name]):.2f}) | {rate:.1f} | {share:.1%} |"
        )


def searches(options: argparse.Namespace) -> tuple[list[WorkOrder], ProblemFiles]:
    """Return searches of about half a second: of a fixed number of iterations."""
    name, planner = SEARCHED
    files = files_of(load(name, overrides=[f"planner.name={planner}"]))
    with tempfile.TemporaryDirectory() as root, LocalEngine(1, Path(root)) as engine:
        files.written(Path(root))
        iterations = 4000
        for _ in range(4):
            order = SearchOrder(0, files.key, seed=1, iterations=iterations)
            (answer,) = engine.answers(iter([order]))
            iterations = max(100, round(iterations * SPAN / max(answer["cpu"], 0.01)))
    found = [
        SearchOrder(k, files.key, seed=k + 1, iterations=iterations) for k in range(options.runs)
    ]
    return found, files


def size(files: ProblemFiles) -> int:
    """Return the size of all files, in bytes."""
    return sum(map(len, files.files.values()))


def sizes() -> Iterator[str]:
    """Yield table rows of what travels."""
    all_files = {name: files_of(load(name)) for name in builtin_scenarios()}
    ordered = sorted(all_files.items(), key=lambda item: size(item[1]))
    name, files = ordered[len(ordered) // 2]
    order = SearchOrder(0, files.key, seed=1)
    with tempfile.TemporaryDirectory() as root, LocalEngine(1, Path(root)) as engine:
        files.written(Path(root))
        (answer,) = engine.answers(iter([order]))
    yield f"| an order | {len(pickle.dumps(order))} |"
    yield f"| an answer ({name}) | {len(pickle.dumps(answer))} |"
    yield f"| files of the smallest scenario ({ordered[0][0]}) | {size(ordered[0][1])} |"
    yield f"| files of the median scenario ({name}) | {size(files)} |"
    yield f"| files of the largest scenario ({ordered[-1][0]}) | {size(ordered[-1][1])} |"


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description="What a Dask cluster costs a study.")
    parser.add_argument("--workers", type=int, default=8, metavar="N")
    parser.add_argument("--runs", type=int, default=320, metavar="N")
    parser.add_argument("--repeats", type=int, default=3, metavar="N")
    parser.add_argument("--parts", default="waiting,searching,nothing,sizes", metavar="NAME,…")
    options = parser.parse_args()
    print(f"{describe()}\n")
    heading = (
        "| {} | start [s] | all runs [s] | runs a second | of processes |\n" + "| --- " * 5 + "|"
    )
    small = files_of(load("pendulum_swingup"))
    for part in options.parts.split(","):
        if part == "sizes":
            print("| what travels | bytes |\n| --- | --- |", *sizes(), sep="\n")
            continue
        if part == "searching":
            orders, files = searches(options)
        else:
            span, files = (SPAN if part == "waiting" else 0.0), small
            orders = [WaitingOrder(k, files.key, span) for k in range(options.runs)]
        print(heading.format(part), *compared(orders, files, options), sep="\n", end="\n\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
