"""Logs and the database are what OMPL's authors' own reader makes of them."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from kinolab.studies.ompl_benchmark import experiments, write_database, write_logs
from tests.studies.tiny_study import LIMITED, TINY, Row, row, study_in

AWKWARD = 'a "quoted" | piped; name,\n\tof\u2028lines\r\'s'
TABLES = ("experiments", "plannerConfigs", "enums", "runs", "progress")
VIEWS = ("bestPlannerConfigsPerExperiment", "bestPlannerConfigs")


def hand_written() -> list[Row]:
    improved = {"improvements": [[0.25, 3.0], [0.5, 2.5], [0.5, 2.0]]}
    swept = {"settings": '{"planner.goal_bias": 0.05, "start.name": "two\\nlines"}'}
    lost = dict.fromkeys(
        ("search", "wall", "cpu", "memory", "iterations", "goal_distance", "began", "load")
    )
    nowhere = dict.fromkeys(("computer", "host", "processor", "cores", "system", "versions"))
    return [
        row(0, **improved),
        row(1, status="approximate", search=1 / 3),
        row(2, status="crashed", **lost),
        row(3, AWKWARD, fixed='{"planner.text": "x | y; z = \\"q\\""}', host="my own host"),
        row(4, AWKWARD, status="not_found", search=1e-7),
        row(5, "sst", **swept, clearance=None),
        row(6, "sst", **swept, status="local_minimum"),
        row(7, "sst", status="killed", **lost, **nowhere),
        row(8, "rrt", scenario="another table", **improved),
        row(9, "rrt", scenario="another_table", seed=2**62),
    ]


def contents(path: Path) -> dict[str, Any]:
    """Return the columns and the rows of all tables and views of a database."""
    with closing(sqlite3.connect(path)) as connection:
        found: dict[str, Any] = {}
        for table in TABLES:
            found[f"{table} columns"] = [
                column[1:] for column in connection.execute(f"PRAGMA table_info({table})")
            ]
            found[table] = connection.execute(f"SELECT * FROM {table}").fetchall()
        for view in VIEWS:
            told = connection.execute(f"SELECT * FROM {view}")
            found[view] = [column[0] for column in told.description], told.fetchall()
        return found


@pytest.mark.parametrize("limits", ["", LIMITED, "[limits]\nsearch = 0.1234567\nmemory = 1e9\n"])
def test_ompls_own_reader_makes_every_table_of_the_logs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], limits: str
) -> None:
    found = experiments(study_in(tmp_path, TINY + limits), hand_written())
    write_database(tmp_path / "ours.db", write_logs(tmp_path, found))
    assert capsys.readouterr().out == ""
    ours = contents(tmp_path / "ours.db")
    assert [len(ours[table]) for table in TABLES] == [3, 4, 12, 10, 4]
    assert ours["progress"][:2] == [(1, 0.25, 3.0), (1, 0.5, 2.0)]
    assert [line[:4] for line in ours["runs"][:3]] == [
        (1, 1, 1, 0.1),
        (2, 1, 1, 1 / 3),
        (3, 1, 1, None),
    ]


def test_a_database_says_what_the_rows_say(tmp_path: Path) -> None:
    found = experiments(study_in(tmp_path, TINY), hand_written())
    write_database(tmp_path / "ours.db", write_logs(tmp_path, found))
    with closing(sqlite3.connect(tmp_path / "ours.db")) as connection:
        ask = """SELECT experiments.name, plannerConfigs.name, solved, solution_length, runs.seed,
            enums.description FROM runs JOIN experiments ON experimentid = experiments.id
            JOIN plannerConfigs ON plannerid = plannerConfigs.id
            JOIN enums ON enums.name = 'status' AND enums.value = runs.status ORDER BY runs.id"""
        told = connection.execute(ask).fetchall()
    assert told[:3] == [
        ("table", "rrt", 1, 2.0, 0, "solved"),
        ("table", "rrt", 0, None, 1, "approximate"),
        ("table", "rrt", 0, None, 2, "crashed"),
    ]
    assert told[3][:2] == (
        "table",
        AWKWARD.replace("\n", " ").replace("\t", " ").replace("\r", " ").replace("\u2028", " "),
    )
    assert told[5][1] == "sst[goal_bias=0.05,start.name=two lines]"
    assert told[9] == ("another_table", "rrt", 1, 2.0, 2**62, "solved")


def test_kinds_of_computers_are_experiments_of_their_own(tmp_path: Path) -> None:
    rows = [row(0), row(1, computer="bbbbbbbb"), row(2, scenario="мир"), row(3, scenario="дом")]
    study = study_in(tmp_path, TINY)
    logs = write_logs(tmp_path, experiments(study, rows))
    assert [log.name for log in logs] == [
        "table@aaaaaaaa.log",
        "table@bbbbbbbb.log",
        "___@aaaaaaaa.log",
        "___@aaaaaaaa.4.log",
    ]
    assert write_logs(tmp_path, experiments(study, rows[:1])) == [tmp_path / "ompl" / "table.log"]
    assert [path.name for path in (tmp_path / "ompl").iterdir()] == ["table.log"]
