"""docs/driving.md: its code runs, and what it says of keys is what the page has."""

from __future__ import annotations

import re
from typing import Any

from tests.javascript_engine import Engine
from tests.support import ROOT

PAGE = ROOT / "docs" / "driving.md"
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)


def test_every_piece_of_code_runs() -> None:
    """Python in one session; then JavaScript with the machine that Python wrote."""
    names: dict[str, Any] = {}
    for language, code in BLOCKS:
        if language == "python":
            exec(code, names)
    (script,) = [code for language, code in BLOCKS if language == "js"]
    body = re.sub(r"^import .*$", "", script, flags=re.MULTILINE)
    with Engine() as engine:
        machine = engine.machine(names["model"])
        moved = engine.run(f"const machine = {machine}; {body}; return Array.from(x)")
    assert len(moved) == names["model"].nx
    assert moved != names["model"].rest().tolist()
