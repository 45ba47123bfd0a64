"""docs/vector_fields.md shows what its code prints."""

from __future__ import annotations

import re
import sys
from contextlib import redirect_stdout
from io import StringIO
from typing import Any
from unicodedata import normalize

from kinolab import cli
from tests.support import ROOT

PAGE = ROOT / "docs" / "vector_fields.md"
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)


def shown() -> list[tuple[str, str, str]]:
    """Return each piece of code: its language, itself, and the output that stands below it."""
    pairs = zip(BLOCKS[::2], BLOCKS[1::2], strict=True)
    return [(language, code, text) for (language, code), (_, text) in pairs]


def outputs() -> list[str]:
    """Return what the code prints, one piece after the other."""
    names: dict[str, Any] = {}
    printed = []
    for language, code, _ in shown():
        with redirect_stdout(StringIO()) as out:
            if language == "python":
                exec(code, names)
            else:
                assert cli.run(code.split()[1:]) == 0
        printed.append(normalize("NFC", out.getvalue()))
    return printed


def test_every_piece_of_code_prints_what_stands_below_it() -> None:
    """If this fails: ``python -m tests.test_vector_fields_page`` writes what is printed."""
    assert {language for language, _, _ in shown()} == {"sh", "python"}
    for (_, code, text), printed in zip(shown(), outputs(), strict=True):
        assert printed == normalize("NFC", text), code


def test_every_name_that_the_page_imports_is_public() -> None:
    import kinolab.dynamics

    imported = re.findall(r"from kinolab\.dynamics import (.*)", PAGE.read_text(encoding="utf-8"))
    names = {name.strip() for line in imported for name in line.split(",")}
    assert len(names) > 5
    assert names <= set(kinolab.dynamics.__all__)


def write() -> None:
    """Write what the code prints below it."""
    text = PAGE.read_text(encoding="utf-8")
    for (language, code, below), printed in zip(shown(), outputs(), strict=True):
        old = f"```{language}\n{code}```\n\n```text\n{below}```"
        assert old in text, code
        text = text.replace(old, f"```{language}\n{code}```\n\n```text\n{printed}```", 1)
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    sys.exit(write())
