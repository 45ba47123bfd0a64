"""Many executions of a plan, in batches, by an engine; memory does not grow with their number."""

from __future__ import annotations

import csv
import io
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from kinolab.analyze.execute.conditions import Conditions
from kinolab.analyze.execute.execution import Execution, ExecutionRun, Executor
from kinolab.concurrency.cancel import CancellationToken, never_cancelled
from kinolab.errors import KinolabError
from kinolab.files import whole_file
from kinolab.runs import Run, read_run
from kinolab.studies.engine import AbstractEngine, MakeEngine
from kinolab.studies.orders import Answer, WorkOrder
from kinolab.studies.problem_files import ProblemFiles, files_in

BATCH = 50  # runs of an order: about a second
NEEDED = ("scenario.toml", "report.json", "trajectory.csv", "trajectory.npz", "assets")
TABLE = "execution.csv"
HEADING = ("run", "outcome", "excess", "deviation", "steps", "time", "why", "detail")


@dataclass(frozen=True)
class ExecutionOrder(WorkOrder):
    """Consecutive executions of a plan.

    Attributes:
        first: Number of the first, from 0.
        count: How many.
        conditions: Perturbations of the machine and its sensors.
        seed: Random seed.
        large: As of ``Executor``.
    """

    first: int
    count: int
    conditions: Conditions
    seed: int
    large: float

    isolated: ClassVar[bool] = False  # a batch is sound, and its tracker is kept

    def prepare(self, folder: Path) -> None:
        """Read the plan, and design the gains along it."""
        self._executor(folder)

    def work(self, folder: Path) -> Answer:
        """Return the runs."""
        executor = self._executor(folder)
        numbers = range(self.first, self.first + self.count)
        return {"status": "done", "runs": [executor.run(k) for k in numbers]}

    def _executor(self, folder: Path) -> Executor:
        key = (folder, self.seed, self.large, repr(self.conditions))
        if key not in _kept:
            _kept.clear()
            run = read_run(folder)
            _kept[key] = Executor(
                run.problem, run.trajectory, self.conditions, seed=self.seed, large=self.large
            )
        return _kept[key]


_kept: dict[tuple[object, ...], Executor] = {}  # of this process; the last one


def executions(
    engine: AbstractEngine,
    files: ProblemFiles,
    conditions: Conditions,
    *,
    runs: int,
    seed: int,
    large: float,
    stop: CancellationToken = never_cancelled,
) -> Iterator[ExecutionRun]:
    """Yield executions of a plan in the order of their numbers, as an engine makes them.

    They are the same as those of one process, bit for bit.

    Raises:
        KinolabError: If a batch fails.
    """
    orders = (
        ExecutionOrder(
            index,
            files.key,
            index * BATCH,
            min(BATCH, runs - index * BATCH),
            conditions,
            seed,
            large,
        )
        for index in range(-(-runs // BATCH))
    )
    early: dict[int, list[ExecutionRun]] = {}
    following = 0
    for answer in engine.answers(orders, stop):
        if answer["status"] != "done":
            raise KinolabError(answer["message"])
        early[answer["index"]] = answer["runs"]
        while following in early:
            yield from early.pop(following)
            following += 1


@contextmanager
def written(path: Path, runs: Iterable[ExecutionRun]) -> Iterator[Iterator[ExecutionRun]]:
    """Pass executions on, and write a row of a CSV file for each; it appears once complete."""
    with whole_file(path) as file:
        text = io.TextIOWrapper(file, encoding="utf-8", newline="")
        yield _rows_written(csv.writer(text, lineterminator="\n"), runs)
        text.flush()
        text.detach()


def _until(stop: CancellationToken, runs: Iterable[ExecutionRun]) -> Iterator[ExecutionRun]:
    for run in runs:
        yield run
        if stop():
            raise KeyboardInterrupt


def _rows_written(writer: Any, runs: Iterable[ExecutionRun]) -> Iterator[ExecutionRun]:
    for k, run in enumerate(runs):
        if not k:
            writer.writerow([*HEADING, *run.parameters])
        told = (k + 1, run.outcome, run.excess, run.deviation, run.steps)
        failure = run.failure
        why: tuple[object, ...] = ("", "", "")
        if failure is not None:
            detail = "; ".join(filter(None, (failure.detail, failure.slip)))
            why = (failure.time, failure.cause, detail)
        writer.writerow([*told, *why, *run.parameters.values()])
        yield run


def execute_many(
    run: Run,
    conditions: Conditions,
    make: MakeEngine | None,
    *,
    runs: int,
    seed: int,
    large: float,
    table: Path,
    told: Callable[[int], None],
    stop: CancellationToken = never_cancelled,
) -> Execution:
    """Execute the plan of a finished run many times, and write how each ended.

    Args:
        conditions: Perturbations of the machine and its sensors.
        make: Makes the engine, from files and the folder they are in; this process does everything
            when None.
        large: As of ``Executor``.
        table: Path of a CSV file with a row for each.
        told: Called after each with their number so far.
        stop: Polled; once set, nothing is written.

    Raises:
        InputError: If the plan has no steps, no machine fits the conditions, or there is no engine.
        KeyboardInterrupt: If ``stop`` was set.
    """
    executor = Executor(run.problem, run.trajectory, conditions, seed=seed, large=large)
    if make is None:
        with written(table, _until(stop, map(executor.run, range(runs)))) as coming:
            return executor.tally(coming, told)
    executor.run(0)  # mistakes in the conditions are told once, here
    files = files_in(run.folder, NEEDED)
    with tempfile.TemporaryDirectory() as root, make([files], Path(root)) as engine:
        made = executions(engine, files, conditions, runs=runs, seed=seed, large=large, stop=stop)
        with written(table, made) as coming:
            found = executor.tally(coming, told)
            if found.total < runs:
                raise KeyboardInterrupt
    return found
