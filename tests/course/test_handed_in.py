"""Forty works that were handed in get the points that a teacher would give.

What is due was said before a grader had seen them (``handed_in/grades.toml``).
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from kinolab.testing.grade_report import Report
from kinolab.testing.grading import grade

nbformat = pytest.importorskip("nbformat")

HOME = Path(__file__).parent / "handed_in"
GRADES: dict[str, dict[str, Any]] = tomllib.loads((HOME / "grades.toml").read_text("utf-8"))
NOTEBOOKS = [name for name, due in GRADES.items() if "chapter" in due]
PROJECTS = [name for name in GRADES if name not in NOTEBOOKS]


@pytest.mark.long
@pytest.mark.parametrize("name", PROJECTS)
def test_a_project_gets_what_a_teacher_would_give(name: str) -> None:
    _agrees(GRADES[name], grade(HOME / name))


@pytest.mark.long
@pytest.mark.parametrize("name", PROJECTS)
def test_so_it_does_where_the_teacher_has_the_right_machine(name: str, tmp_path: Path) -> None:
    given = Path(name).stem
    for kind in (".py", ".toml"):
        text = (HOME / given).with_suffix(kind).read_text("utf-8")
        for wrong, right in GRADES[name].get("mended", ()):
            text = text.replace(wrong, right)
        (tmp_path / given).with_suffix(kind).write_text(text, "utf-8")
    _agrees(GRADES[name], grade(HOME / name, against=tmp_path / name))


@pytest.mark.long
@pytest.mark.parametrize("name", NOTEBOOKS)
def test_so_do_the_exercises_of_a_chapter(name: str, tmp_path: Path) -> None:
    due = GRADES[name]
    cells = [cell for cell in (HOME / name).read_text("utf-8").split("# %%") if cell.strip()]
    work = tmp_path / f"{due['chapter']}.ipynb"
    nbformat.write(nbformat.v4.new_notebook(cells=[*map(nbformat.v4.new_code_cell, cells)]), work)
    report = grade(work)
    for mark in report.marks:
        least, most = due["exercises"][mark.exercise]
        assert least <= mark.points <= most, str(report)


def _agrees(due: dict[str, Any], report: Report) -> None:
    assert due["low"] <= report.points <= due["high"], str(report)
    patterns = due["words"]
    named = any(re.search(pattern, str(report), re.IGNORECASE | re.DOTALL) for pattern in patterns)
    assert named or not patterns, str(report)
