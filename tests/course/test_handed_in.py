"""Ten projects that were handed in get the points that a teacher would give.

What is due was said before a grader had seen them (``handed_in/grades.toml``).
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from kinolab.testing.grading import grade

HOME = Path(__file__).parent / "handed_in"
GRADES: dict[str, dict[str, Any]] = tomllib.loads((HOME / "grades.toml").read_text("utf-8"))


@pytest.mark.long
@pytest.mark.parametrize("name", GRADES)
def test_a_project_gets_what_a_teacher_would_give(name: str) -> None:
    due, report = GRADES[name], grade(HOME / name)
    assert due["low"] <= report.points <= due["high"], str(report)
    patterns = due["words"]
    named = any(re.search(pattern, str(report), re.IGNORECASE | re.DOTALL) for pattern in patterns)
    assert named or not patterns, str(report)
