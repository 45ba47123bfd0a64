"""Pages of docs/ show what their code prints.

Every piece of code stands above what it prints; what is only shown is indented instead.
"""

from __future__ import annotations

import re
import sys
from contextlib import chdir, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unicodedata import normalize

import pytest

from kinolab import cli
from tests.support import ROOT

NAMES = (
    *("vector_fields.md", "feedback.md", "python.md", "tools.md"),
    *("walk.md", "not_as_expected.md"),
)
PAGES = [ROOT / "docs" / name for name in NAMES]


def shown(page: Path) -> list[tuple[str, str, str]]:
    """Return each piece of code: its language, itself, and the output that stands below it."""
    text = page.read_text(encoding="utf-8")
    blocks = re.findall(r"```(\w+)\n(.*?)```", text, flags=re.DOTALL)
    pairs = zip(blocks[::2], blocks[1::2], strict=True)
    return [(language, code, text) for (language, code), (_, text) in pairs]


def outputs(page: Path) -> list[str]:
    """Return what the code prints, one piece after the other; files go to a folder that is gone."""
    names: dict[str, Any] = {}
    printed = []
    with TemporaryDirectory() as folder, chdir(folder):
        for language, code, _ in shown(page):
            with redirect_stdout(StringIO()) as out:
                if language == "python":
                    exec(code, names)
                else:
                    assert cli.run(code.split()[1:]) == 0
            printed.append(normalize("NFC", out.getvalue()))
    return printed


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_piece_of_code_prints_what_stands_below_it(page: Path) -> None:
    """If this fails: ``python -m tests.docs.test_executed_pages`` writes what is printed."""
    assert {language for language, _, _ in shown(page)} <= {"sh", "python"}
    for (_, code, text), printed in zip(shown(page), outputs(page), strict=True):
        assert printed == normalize("NFC", text), code


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_name_that_the_page_imports_is_public(page: Path) -> None:
    import kinolab.dynamics

    imported = r"from kinolab\.dynamics import (?:\(([^)]*)\)|(.*))"
    found = re.findall(imported, page.read_text(encoding="utf-8"))
    names = {name.strip() for lines in found for name in "".join(lines).split(",")} - {""}
    assert len(names) > 5 or page.stem == "tools"  # whose machines are in files
    assert names <= set(kinolab.dynamics.__all__)


def write(page: Path) -> None:
    """Write what the code prints below it."""
    text = page.read_text(encoding="utf-8")
    for (language, code, below), printed in zip(shown(page), outputs(page), strict=True):
        old = f"```{language}\n{code}```\n\n```text\n{below}```"
        assert old in text, code
        text = text.replace(old, f"```{language}\n{code}```\n\n```text\n{printed}```", 1)
    page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(any(map(write, PAGES)))
