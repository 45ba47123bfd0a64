"""Grades of notebooks that were handed in, and of projects."""

from __future__ import annotations

import csv
import io
import os
import re
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from kinolab import cli
from kinolab.cli.commands.plan_course import write_course
from kinolab.errors import InputError
from kinolab.testing import grade, grade_class, grading
from kinolab.testing.answers.answers_from_afar import processes_with
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
    assert points["nothing is wrong with the machine"] == 4
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


def test_what_is_due_is_said_to_teachers_alone(tmp_path: Path) -> None:
    """A notebook that reads its marks learns nothing that it could answer then."""
    reads = "import re\nmark = check('3.3', 1.5)\nassert mark.due == '' and '2' not in mark.reason"
    work = handed_in(tmp_path / "eve.ipynb", CHECK + reads)
    told: list[str] = []
    report = grade(work, due=True, told=told.append)
    assert report.errors == ()
    assert "it is 1.5 where 2 is due." in str(report)
    assert "where" not in str(grade(work))
    assert told[0] == "cell 1 of 1"
    assert re.fullmatch(r"cell 1 of 1 took \d+\.\d s", told[1])


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


PATCH = """
import kinolab.testing.exercises as e, kinolab.testing.answers.judging as j
e.judged = lambda exercise, answer: e.Mark(exercise.name, 10**9, 10**9)
j.Exercise.judge = lambda *_: None
for one in e.exercises().values():
    object.__setattr__(one, "judge", lambda _: None)
    object.__setattr__(one, "points", 10**9)
check("3.3", 1.5)
"""
FORGED = """
import json, os
from multiprocessing.connection import Client
for text in ('{"mark": {"exercise": "3.3", "points": 9, "of": 9, "reason": ""}}', "[", "[]",
             '{"exercise": "3.3", "points": 9, "answer": 1.5}', '{"exercise": "9.9", "answer": 2}'):
    with Client(os.environ["KINOLAB_GRADES"], "AF_UNIX") as line:
        line.send_bytes(text.encode())
        try:
            print(line.recv_bytes())
        except EOFError:
            pass
"""
WRITTEN = """
import os
try:
    os.remove(os.environ["KINOLAB_GRADES"])
    open(os.environ["KINOLAB_GRADES"], "w").write('{"exercise": "3.3", "points": 9, "of": 9}')
except OSError:
    pass
"""
PRETENDING = """
class Two(float):
    def __float__(self): return 2.0
    def __eq__(self, other): return True
    def __sub__(self, other): return 0.0
check("3.2", Two(7)); check("3.3", Two(7))
"""


@pytest.mark.parametrize("code", [PATCH, FORGED, WRITTEN, PRETENDING])
def test_a_notebook_cannot_give_itself_marks(code: str, tmp_path: Path) -> None:
    """They are made in another process, of data, and by its own exercises."""
    report = grade(handed_in(tmp_path / "eve.ipynb", CHECK + 'check("3.1", ...)', code))
    assert [(mark.points, mark.of) for mark in report.marks] == [(0, 2), (0, 3), (0, 1)]


def test_a_notebook_that_breaks_the_protocol_is_graded_up_to_there(tmp_path: Path) -> None:
    """What its process says to Jupyter has no header then; a class is graded on."""
    forged = "import json\njson.dumps = lambda *_, **__: '{}'\njson.loads = lambda *_, **__: {}\n"
    work = handed_in(tmp_path / "eve.ipynb", CHECK + 'check("3.3", 2.0)', forged, "2 + 2")
    report = grade(work)
    assert report.points == 1
    assert any("sends what is no message" in error for error in report.errors)


def test_a_notebook_that_removes_the_way_to_its_grader_is_graded_up_to_there(
    tmp_path: Path,
) -> None:
    removed = "import os, shutil\nshutil.rmtree(os.path.dirname(os.environ['KINOLAB_GRADES']))"
    later = 'check("3.1", lambda *q: (0.0, 0.0))'
    report = grade(handed_in(tmp_path / "eve.ipynb", CHECK + 'check("3.3", 2.0)', removed, later))
    assert report.points == 1
    assert "Cell 3 fails: FileNotFoundError" in report.errors[-1]


def test_a_notebook_writes_nothing_to_the_terminal(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Escapes neither: not past Jupyter, and not by what it starts."""
    written = "import os\nos.write(1, b'\\x1b[2J')\nos.write(2, b'E')\nos.system('echo mine')"
    grade(handed_in(tmp_path / "eve.ipynb", CHECK + 'check("3.3", 2.0)', written))
    assert capfd.readouterr() == ("", "")


def test_what_a_notebook_has_started_is_ended(tmp_path: Path) -> None:
    """Also what is in a session of its own."""
    start = """
import subprocess, sys
code = "import os, time; open('PLACE', 'w').write(str(os.getpid())); time.sleep(600)"
subprocess.Popen([sys.executable, "-c", code], start_new_session=True)
import time, pathlib
while not (pathlib.Path("PLACE").exists() and pathlib.Path("PLACE").read_text()): time.sleep(0.05)
""".replace("PLACE", str(tmp_path / "pid"))
    grade(handed_in(tmp_path / "eve.ipynb", CHECK + 'check("3.3", 2.0)', start))
    process = int((tmp_path / "pid").read_text())
    psutil = pytest.importorskip("psutil")
    assert not psutil.pid_exists(process) or psutil.Process(process).status() == "zombie"


@pytest.mark.parametrize("count", [1, 300])
def test_what_is_printed_without_end_is_not_kept(
    count: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At once, or in many pieces; what follows still counts."""
    monkeypatch.setattr(grading, "MOST_OUTPUT", 100_000)
    code = f"for _ in range({count}):\n    print('x' * ({300_000 // count}), flush=True)"
    work = handed_in(tmp_path / "eve.ipynb", CHECK + 'check("3.3", 2.0)', code)
    report = grade(work)
    assert report.points == 1
    if count > 1:
        assert any("It prints more than" in error for error in report.errors)


def waiting(folder: Path, then: Callable[[], None]) -> Path:
    """Return a notebook that waits for ever; something is done once its last cell has begun."""
    there = folder / "there"
    code = f"open({str(there)!r}, 'w').close()\nimport time\ntime.sleep(600)"

    def act() -> None:
        while not there.exists():
            time.sleep(0.05)
        then()

    threading.Thread(target=act, daemon=True).start()
    return handed_in(folder / "eve.ipynb", CHECK + 'check("3.3", 2.0)', code)


def test_a_notebook_has_a_time_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It ends when a cell that waits has begun."""
    work = waiting(tmp_path, lambda: monkeypatch.setattr(grading, "NOTEBOOK_SECONDS", 0.0))
    report = grade(work)
    assert report.points == 1
    assert any("what was left has not run" in error for error in report.errors)


def test_grading_that_is_interrupted_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    places: list[str] = []
    made = grading.judging

    @contextmanager
    def noted(judge: Any) -> Iterator[str]:
        with made(judge) as address:
            places.append(address)
            yield address

    monkeypatch.setattr(grading, "judging", noted)
    work = waiting(tmp_path, lambda: os.kill(os.getpid(), signal.SIGINT))
    with pytest.raises(KeyboardInterrupt):
        grade(work)
    (address,) = places
    assert not Path(address).parent.exists()
    assert processes_with("KINOLAB_GRADES", address) == []
