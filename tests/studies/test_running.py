"""Runs have processes of their own: whatever one of them does, the others' rows stay the same."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from kinolab.errors import InputError
from kinolab.studies.columns import COLUMNS
from kinolab.studies.orders import SearchOrder
from kinolab.studies.run_study import StudyFolder, StudyPart
from kinolab.studies.study_file import Study
from tests.studies.tiny_study import LIMITED, SWINGS, Row, differing, kept, rows_made, study_in

psutil = pytest.importorskip("psutil")

WORKER = "kinolab.studies.worker_process"

FAULTY = '''
"""Planners that fail in every way, by their setting."""

import os
import signal
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from kinolab.search import AbstractPlanner, Outcome, SearchResult, setting


@dataclass(frozen=True, kw_only=True)
class Faulty(AbstractPlanner):
    """Does what it should, or not."""

    name: ClassVar[str] = "faulty"

    fault: str = setting("none", meaning="What it does.")

    def solve(self, problem, seed, budget):
        if self.fault == "signal":
            os.kill(os.getpid(), signal.SIGSEGV)
        if self.fault == "exit":
            os._exit(3)
        if self.fault == "raise":
            raise RuntimeError("this planner is broken")
        if budget.max_iterations != 1:  # of the rehearsal
            held = []
            while self.fault == "memory":
                held.append(np.ones(1_000_000))
            while self.fault == "spin":
                pass
        u = np.zeros((1, problem.model.nu))
        t = problem.step * np.arange(2.0)
        return SearchResult(Outcome.SOLVED, t, u, np.int64(1))
'''

REACHED = """\
schema = 1
title = "It hangs where it shall hang"
[system]
name = "pendulum"
[goal]
theta = 0.0
tolerance = 0.5
"""

FAULTS = {
    "none": "solved",
    "signal": "crashed",
    "exit": "crashed",
    "raise": "error",
    "memory": "memory_limit",
    "spin": "cpu_limit",
}


def workers() -> list[psutil.Process]:
    """Return the processes that do orders for this one, and their runs."""
    children = psutil.Process().children(recursive=True)
    return [child for child in children if WORKER in " ".join(child.cmdline())]


@pytest.fixture(autouse=True)
def _nobody_is_left() -> Iterator[None]:
    yield
    assert workers() == []


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> list[Row]:
    """The rows of eight runs, made one after the other."""
    folder = tmp_path_factory.mktemp("undisturbed")
    return rows_made(eight(folder), folder / "out")


def eight(folder: Path) -> Study:
    text = SWINGS.replace('["kpiece_fast"]', '["kpiece_fast", "rrt_fast"]')
    return study_in(folder, f"{text}seeds = 4\n{LIMITED}")


def test_whatever_a_planner_does_the_rows_of_others_are_what_they_are(
    tmp_path: Path, undisturbed: list[Row]
) -> None:
    """The last of them has the planner, scenario and seed of the first undisturbed one.

    A limit of 2 s of processor time is ten times what a sound run takes here.
    """
    (tmp_path / "faulty.py").write_text(FAULTY)
    (tmp_path / "still.toml").write_text(REACHED)
    faults = "\n".join(
        f'[[case]]\nscenarios = ["still.toml"]\nplanners = [{{ name = "faulty.py:Faulty", '
        f'label = "{fault}", settings = {{ fault = "{fault}" }} }}]'
        for fault in FAULTS
    )
    fine = '[[case]]\nscenarios = ["swing.toml"]\nplanners = ["kpiece_fast"]\n'
    limits = "[limits]\ncpu = 2.0\nmemory = 600.0\niterations = 3000\n"
    text = f'schema = 1\ntitle = "Faults"\n{limits}{faults}\n{fine}'
    rows = rows_made(study_in(tmp_path, text), tmp_path / "out")
    ends = {row["planner"]: row["status"] for row in rows}
    assert ends == {**FAULTS, "kpiece_fast": "solved"}
    told = {row["planner"]: row for row in rows}
    assert "SIGSEGV" in told["signal"]["message"]
    assert "this planner is broken" in told["raise"]["message"]
    assert told["spin"]["cpu"] > 2.0
    assert told["memory"]["memory"] > 600.0
    assert all(row["computer"] and row["host"] for row in rows)
    assert [row["solved"] for row in rows] == [row["status"] == "solved" for row in rows]
    assert (undisturbed[0]["planner"], undisturbed[0]["seed"]) == ("kpiece_fast", 1)
    assert undisturbed[0]["motion"] == told["kpiece_fast"]["motion"] is not None
    assert kept(tmp_path / "out") == sorted(rows, key=lambda row: row["index"])


def test_a_rehearsal_has_limits_too() -> None:
    """Or a planner that heeds none would hold up a study before its first run."""
    order = SearchOrder(
        0, "files", seed=1, cpu_limit=1.0, memory_limit=500.0, improve=True, check=True
    )
    rehearsal = order.rehearsal
    assert isinstance(rehearsal, SearchOrder)
    assert (rehearsal.memory_limit, rehearsal.iterations) == (500.0, 1)
    assert rehearsal.cpu_limit is not None
    assert (rehearsal.improve, rehearsal.check) == (False, False)


def test_two_workers_make_the_same_rows_as_one(tmp_path: Path, undisturbed: list[Row]) -> None:
    rows = rows_made(eight(tmp_path), tmp_path / "out", workers=2)
    assert differing(rows, undisturbed) == []
    assert [row["index"] for row in rows] == [*range(8)]
    assert all(row["status"] == "solved" and row["iterations"] <= 3000 for row in rows)


def test_what_differs_is_found(undisturbed: list[Row]) -> None:
    other = [{**row} for row in undisturbed]
    other[3]["duration"] += 1e-12
    other[4]["wall"] = 1e3
    assert differing(undisturbed, other[:-1]) == [3, 7]
    assert {*undisturbed[0]} == {column.name for column in COLUMNS}


def test_a_worker_that_is_killed_changes_no_row(tmp_path: Path, undisturbed: list[Row]) -> None:
    killed = []

    def kill(_: object) -> None:
        if len(killed) < 2:
            killed.append(workers()[0].pid)
            os.kill(killed[-1], signal.SIGKILL)

    rows = rows_made(eight(tmp_path), tmp_path / "out", told=kill)
    assert len(set(killed)) == 2
    assert differing(rows, undisturbed) == []


def test_after_an_interrupt_only_the_missing_runs_are_made(
    tmp_path: Path, undisturbed: list[Row]
) -> None:
    study, out, told = eight(tmp_path), tmp_path / "out", list[object]()
    first = rows_made(study, out, told=told.append, stop=lambda: len(told) >= 3)
    assert 3 <= len(first) < 8
    path = out / "rows.jsonl"
    path.write_bytes(path.read_bytes()[:-9])  # a crash has cut the last line
    rows = rows_made(study, out, resume=True)
    assert differing(rows, undisturbed) == []
    assert kept(out)[: len(first) - 1] == first[:-1]  # those were not made again
    with pytest.raises(InputError, match=r"there are 8 runs of a study\. --resume keeps them"):
        StudyFolder(study, out)


def test_parts_make_up_the_whole(tmp_path: Path, undisturbed: list[Row]) -> None:
    study = eight(tmp_path)
    one = rows_made(study, tmp_path / "1", part=StudyPart(1, 2))
    two = rows_made(study, tmp_path / "2", part=StudyPart(2, 2))
    assert [row["index"] for row in (*one, *two)] == [0, 2, 4, 6, 1, 3, 5, 7]
    others = [tmp_path / "1", tmp_path / "2"]
    whole = rows_made(study, tmp_path / "whole", others=others)
    assert differing(whole, undisturbed) == []
    assert kept(tmp_path / "whole") == [*one, *two]
    with pytest.raises(InputError, match="there are no rows of a study"):
        rows_made(study, tmp_path / "none", others=[tmp_path / "nowhere"])


def test_rows_of_another_study_are_refused(tmp_path: Path, undisturbed: list[Row]) -> None:
    study, out = eight(tmp_path), tmp_path / "out"
    rows_made(study, out, part=StudyPart(1, 8))
    other = study_in(tmp_path, f"{SWINGS}seeds = 8\n[limits]\niterations = 2000\n", "other.toml")
    with pytest.raises(InputError, match="row 0 there is of another study"):
        StudyFolder(other, out, resume=True)
    assert kept(out)[0]["motion"] == undisturbed[0]["motion"]


def test_runs_that_are_checked_pass_from_their_files(tmp_path: Path) -> None:
    (row,) = rows_made(study_in(tmp_path, f"{SWINGS}check = true\n{LIMITED}"), tmp_path / "out")
    assert (row["status"], row["checked"]) == ("solved", True)
