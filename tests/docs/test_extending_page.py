"""docs/extending.md: its code runs, and the functions that it lists are those that files have."""

from __future__ import annotations

import re

import sympy

from kinolab.dynamics.language.json.expression_tree import OPERATIONS
from tests.support import ROOT

PAGE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")


def test_its_code_runs() -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    assert len(blocks) == 2
    for block in blocks:
        exec(block, {})


def test_it_lists_the_functions_there_are() -> None:
    (row,) = re.findall(r"^\| functions \| (.*) \|$", PAGE, re.MULTILINE)
    known = {kind.__name__ for kind in OPERATIONS.values()} - {"Add", "Mul", "Pow"}
    assert set(re.findall(r"`(\w+)`", row)) == known | {"sqrt"}


def test_the_angle_it_gives_is_that_of_two_arguments() -> None:
    text = "2 * atan(y / (x + sqrt(x**2 + y**2)))"
    assert f"`{text}`" in PAGE
    for x, y in ((1, 2), (-3, 0.5), (-1, -4), (2, -0.1)):
        found = eval(text, {"x": x, "y": y, "atan": sympy.atan, "sqrt": sympy.sqrt})
        assert abs(float(found - sympy.atan2(y, x))) < 1e-12
