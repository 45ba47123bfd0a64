"""Grades of notebooks that were handed in, and of projects."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import pytest

from kinolab import cli
from kinolab.cli.commands.plan_course import write_course
from kinolab.errors import InputError
from kinolab.testing import grade, grade_class
from kinolab.testing.exercises import Mark
from kinolab.testing.grading import recorded_marks
from tests.support import OPEN

nbformat = pytest.importorskip("nbformat")


def handed_in(path: Path, *cells: str) -> Path:
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(c) for c in cells])
    nbformat.write(notebook, path)
    return path


CHECK = "from kinolab.testing import check\n"


def test_the_last_answer_to_each_exercise_counts(tmp_path: Path) -> None:
    work = handed_in(
        tmp_path / "ada.ipynb",
        CHECK + 'check("3.3", 1.5)',
        'check("3.3", 2.0)',
        'raise ValueError("what is this")',
        'check("3.1", lambda *q: (0.0, 0.0))',
    )
    report = grade(work)
    assert [(v.exercise, v.points, v.of) for v in report.marks] == [
        ("3.1", 0, 2), ("3.2", 0, 3), ("3.3", 1, 1),
    ]  # fmt: skip
    assert (report.points, report.of) == (1, 6)
    assert report.errors == ("Cell 3 fails: ValueError: what is this",)
    assert str(report).splitlines()[0] == f"{work}: 1 of 6 points"
    assert "3.2: not yet: it was not reached" in str(report)


def test_a_notebook_leaves_no_files_and_cannot_end_the_grader(tmp_path: Path) -> None:
    work = handed_in(
        tmp_path / "eve.ipynb",
        'open("mine.txt", "w").write("x")',
        CHECK + 'check("3.3", 2.0)',
        "import os; os._exit(1)",
        'check("3.1", lambda *q: (0.0, 0.0))',
    )
    report = grade(work)
    assert report.points == 1
    assert any("ended" in error for error in report.errors)
    assert not Path("mine.txt").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["eve.ipynb"]


@pytest.mark.parametrize("content", ["", "{}", "no notebook", '{"cells": 3, "nbformat": 4}'])
def test_what_is_no_notebook_is_a_mistake(content: str, tmp_path: Path) -> None:
    (tmp_path / "a.ipynb").write_text(content)
    with pytest.raises(InputError):
        grade(tmp_path / "a.ipynb")
    with pytest.raises(InputError):
        grade(tmp_path / "absent.ipynb")


def test_a_class_has_a_row_for_each(tmp_path: Path) -> None:
    works = [
        handed_in(tmp_path / "ada.ipynb", CHECK + 'check("3.3", 2.0)'),
        handed_in(tmp_path / "bob.ipynb", CHECK + 'check("3.3", 3.0)'),
        tmp_path / "lost.ipynb",
    ]
    rows = list(csv.DictReader(io.StringIO(grade_class(works, jobs=2))))
    assert [Path(row["work"]).stem for row in rows] == ["ada", "bob", "lost"]
    assert [row["points"] for row in rows] == ["1", "0", "0"]
    assert [row["3.3"] for row in rows] == ["1", "0", ""]
    assert "lost.ipynb" in rows[2]["remarks"]


def test_a_project_is_graded_by_what_can_be_measured(tmp_path: Path) -> None:
    (tmp_path / "table.toml").write_text(OPEN.replace('"rrt"', '"rrt_fast"'))
    report = grade(tmp_path / "table.toml")
    points = {mark.exercise: mark.points for mark in report.marks}
    assert report.of == 12
    assert points["the laws of mechanics hold"] == 4
    assert points["more than the rolling disk"] == 0  # it is one
    assert points["a plan is found"] == 3
    assert points["it is proved"] == 2


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"x = 0.0": "x = -1.0"}, "it starts in its goal"),
        ({"x = 0.0\ny = 0.0\n": ""}, "nothing says where it shall go"),
        ({"x = -1.0": "x = -9.0"}, "x"),
    ],
)
def test_a_project_without_a_task_keeps_the_points_of_its_machine(
    changes: dict[str, str], reason: str, tmp_path: Path
) -> None:
    text = OPEN
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "table.toml").write_text(text)
    report = grade(tmp_path / "table.toml")
    assert [mark.points for mark in report.marks] == [4, 0, 0, 0, 0]
    assert all(reason in mark.reason for mark in report.marks[2:])


def test_notebooks_are_written_once_and_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "mine"
    assert cli.run(["course", str(folder)]) == 0
    notebooks = sorted(folder.glob("*.ipynb"))
    assert len(notebooks) == 12
    notebooks[2].write_text("my work")
    assert not any(new for _, new in write_course(folder))
    assert notebooks[2].read_text() == "my work"
    assert "next: jupyter lab" in capsys.readouterr().out


def test_a_chapter_as_it_comes_has_no_points_and_no_solutions(tmp_path: Path) -> None:
    write_course(tmp_path)
    (chapter,) = tmp_path.glob("03_*.ipynb")
    report = grade(chapter)
    assert report.points == 0
    assert all(mark.reason for mark in report.marks)
    assert "hide-cell" not in chapter.read_text()


def test_grades_from_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    work = handed_in(tmp_path / "ada.ipynb", CHECK + 'check("3.3", 2.0)')
    assert cli.run(["course", "--grade", str(work)]) == 0
    assert "1 of 6 points" in capsys.readouterr().out


def test_what_a_notebook_writes_into_its_record_is_a_mark_or_nothing(tmp_path: Path) -> None:
    record = tmp_path / "grades.jsonl"
    assert recorded_marks(record) == {}
    sound = {"exercise": "1.1", "points": 1, "of": 2, "reason": "it is 3."}
    lines = [sound, {**sound, "points": 2}, [1], {**sound, "points": "3"}, {"exercise": "1.2"}]
    text = "\n".join([*map(json.dumps, lines), "[" * 10**5, "\udcff"])
    record.write_bytes(text.encode(errors="surrogateescape"))
    assert recorded_marks(record) == {"1.1": Mark("1.1", 2, 2, "it is 3.")}
