"""The page about searches that find nothing quotes what kinolab says."""

from __future__ import annotations

import re

import pytest

from tests.support import ROOT

PAGE = (ROOT / "docs" / "nothing_found.md").read_text("utf-8")
ROWS = re.findall(r"^\| `([^`]+)` \|", PAGE, flags=re.MULTILINE)
PACKAGE = ROOT / "src" / "kinolab"
SOURCES = [*(PACKAGE / "analyze" / "diagnose").rglob("*.py"), PACKAGE / "problem/static_holding.py"]
# Literals that stand one after the other are one; what is filled in, on the page, is a number or …
LEAST = 10  # characters that are no coincidence
SAID = re.sub(r'"\s*\n\s*f?"', "", "\n".join(path.read_text("utf-8") for path in SOURCES))


@pytest.mark.parametrize("sentence", ROWS)
def test_kinolab_says_what_the_page_quotes(sentence: str) -> None:
    parts = [part.strip(" ,.:()") for part in re.split(r"…|\d+|about|misses|with", sentence)]
    assert any(part in SAID for part in parts if len(part) >= LEAST)


def test_the_page_quotes_something() -> None:
    assert len(ROWS) >= 10
