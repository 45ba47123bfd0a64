"""Twelve plans fail for twelve reasons, and ``plan execute`` names them.

The true reasons were found by other means, before (``failing/reasons.toml``).
"""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from pathlib import Path
from typing import Any

import pytest

from tests.support import plan

HOME = Path(__file__).parent / "failing"
REASONS: dict[str, dict[str, Any]] = tomllib.loads((HOME / "reasons.toml").read_text("utf-8"))


@pytest.mark.long
@pytest.mark.parametrize("name", REASONS)
def test_the_reason_that_is_named_is_the_true_one(name: str, tmp_path: Path) -> None:
    true = REASONS[name]
    made = plan(HOME / name, "--no-animation", "--out", tmp_path / "run", cwd=tmp_path)
    assert made.returncode == 0, made.stderr
    options = [*shlex.split(true["options"]), "--no-picture", "--no-diagnosis"]
    done = plan("execute", tmp_path / "run", *options, cwd=tmp_path)
    counts = json.loads((tmp_path / "run" / "execution.json").read_text("utf-8"))["counts"]
    fewest, most = true["failed"]
    assert fewest <= counts.get(true["outcome"], 0) <= most, done.stdout
    for patterns in true["words"]:
        found = (re.search(pattern, done.stdout, re.IGNORECASE) for pattern in patterns)
        assert any(found), done.stdout
