"""docs/reference.md has every public name, as the docstrings describe it."""

from __future__ import annotations

import inspect
import re
from importlib import import_module
from runpy import run_path

import pytest

from tests.support import ROOT

SCRIPT = run_path(str(ROOT / "tools" / "write_reference.py"))
PAGE = (ROOT / "docs" / "reference.md").read_text(encoding="utf-8")
MODULES = {name: import_module(name) for name in SCRIPT["MODULES"]}


def test_the_page_is_what_its_script_writes() -> None:
    """If this fails: ``python tools/write_reference.py``."""
    assert SCRIPT["page"]() == PAGE


@pytest.mark.parametrize("name", MODULES)
def test_every_public_name_is_on_the_page(name: str) -> None:
    section = re.search(rf"^## {re.escape(name)}\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL)
    assert section
    headings = re.findall(r"^### `(\w+)`$", section[1], re.MULTILINE)
    assert set(headings) >= set(getattr(MODULES[name], "__all__", ()))
    assert len(headings) == len(set(headings)) > 0


@pytest.mark.parametrize("name", MODULES)
def test_every_public_class_and_function_has_a_docstring_of_its_own(name: str) -> None:
    for word in getattr(MODULES[name], "__all__", ()):
        thing = getattr(MODULES[name], word)
        if inspect.isclass(thing) or inspect.isfunction(thing):
            own = vars(thing).get("__doc__") if inspect.isclass(thing) else thing.__doc__
            assert own, f"{name}.{word}"
            assert not own.startswith(f"{word}("), f"{name}.{word}"  # what dataclasses write


def test_docstrings_become_markdown() -> None:
    given = ["Do it.", "", "Args:", "    x: States,", "        shape (nx,)."]
    wanted = ["Do it.", "", "**Args**", "", "- `x`: States,", "  shape (nx,)."]
    assert SCRIPT["markdown"]("\n".join(given)) == "\n".join(wanted)
    assert SCRIPT["markdown"]("It.\n\nSource: a book.") == "It.\n\n**Source**: a book."
