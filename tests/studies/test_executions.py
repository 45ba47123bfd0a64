"""Many executions by an engine are those of one process, bit for bit."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinolab.analyze.execute.conditions import Conditions
from kinolab.runs import read_run
from kinolab.studies import executions
from kinolab.studies.engine import AbstractEngine, LocalEngine
from kinolab.studies.executions import execute_many
from kinolab.studies.problem_files import ProblemFiles
from tests.conftest import Finished

CONDITIONS = Conditions(parameters=0.05, noise=0.001, disturbance=0.02)
BATCH = 5  # runs of an order; of 50 each, as usual, three batches would take seconds
RUNS = 2 * BATCH + 3

Make = Callable[[Iterable[ProblemFiles], Path], AbstractEngine]


@pytest.fixture(autouse=True)
def _small_batches(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(executions, "BATCH", BATCH)


def local(workers: int) -> Make:
    def make(files: Iterable[ProblemFiles], root: Path) -> AbstractEngine:
        for one in files:
            one.written(root)
        return LocalEngine(workers, root)

    return make


def executed(folder: Path, make: Make | None, table: Path, **options: Any) -> Any:
    told: list[int] = []
    options = {"runs": RUNS, "seed": 5, "told": told.append, **options}
    found = execute_many(read_run(folder), CONDITIONS, make, large=0.2, table=table, **options)
    assert told == [*range(1, options["runs"] + 1)]
    return found


def test_an_engine_executes_as_one_process_does(table_run: Finished, tmp_path: Path) -> None:
    alone = executed(table_run.folder, None, tmp_path / "alone.csv")
    shared = executed(table_run.folder, local(2), tmp_path / "shared.csv")
    content = (tmp_path / "alone.csv").read_bytes()
    assert (tmp_path / "shared.csv").read_bytes() == content
    assert (alone.counts, alone.worst) == (shared.counts, shared.worst)
    for one, two in zip(alone.runs, shared.runs, strict=True):
        assert one.x.tobytes() == two.x.tobytes()
    heading, *rows = csv.reader(content.decode().splitlines())
    assert heading[:5] == ["run", "outcome", "excess", "deviation", "steps"]
    assert [int(row[0]) for row in rows] == [*range(1, RUNS + 1)]
    assert sum(alone.counts.values()) == RUNS
    masses = np.array([float(row[heading.index("m")]) for row in rows])
    assert len(set(masses)) == RUNS  # each machine is another one,
    assert np.ptp(masses) <= 0.1 * masses.mean() * 1.1  # within 5 % of the plan's


@pytest.mark.parametrize("make", [None, local(1)], ids=["one process", "an engine"])
def test_an_interrupt_writes_nothing(
    table_run: Finished, tmp_path: Path, make: Make | None
) -> None:
    asked: list[int] = []

    def stop() -> bool:
        asked.append(1)
        return len(asked) > 2

    with pytest.raises(KeyboardInterrupt):
        execute_many(
            read_run(table_run.folder),
            CONDITIONS,
            make,
            runs=100 * BATCH,
            seed=5,
            large=0.2,
            table=tmp_path / "execution.csv",
            told=lambda _: None,
            stop=stop,
        )
    assert [*tmp_path.iterdir()] == []
