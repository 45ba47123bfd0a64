"""Ten projects that were handed in get the points that a teacher would give.

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

HOME = Path(__file__).parent / "handed_in"
GRADES: dict[str, dict[str, Any]] = tomllib.loads((HOME / "grades.toml").read_text("utf-8"))


@pytest.mark.long
@pytest.mark.parametrize("name", GRADES)
def test_a_project_gets_what_a_teacher_would_give(name: str) -> None:
    _agrees(GRADES[name], grade(HOME / name))


@pytest.mark.long
@pytest.mark.parametrize("name", GRADES)
def test_so_it_does_where_the_teacher_has_the_right_machine(name: str, tmp_path: Path) -> None:
    given = Path(name).stem
    for kind in (".py", ".toml"):
        text = (HOME / given).with_suffix(kind).read_text("utf-8")
        for wrong, right in GRADES[name].get("mended", ()):
            text = text.replace(wrong, right)
        (tmp_path / given).with_suffix(kind).write_text(text, "utf-8")
    _agrees(GRADES[name], grade(HOME / name, against=tmp_path / name))


def _agrees(due: dict[str, Any], report: Report) -> None:
    assert due["low"] <= report.points <= due["high"], str(report)
    patterns = due["words"]
    named = any(re.search(pattern, str(report), re.IGNORECASE | re.DOTALL) for pattern in patterns)
    assert named or not patterns, str(report)
