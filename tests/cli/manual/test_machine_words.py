"""docs/machines.md explains every word of machines, and all that it shows is so."""

from __future__ import annotations

import ast
import inspect
import re

import pytest

import kinolab.dynamics
from kinolab.cli.manual.machine_words import SOURCE, described
from kinolab.cli.manual.sections import ManualSection, sections_of, source_of
from tests.cli.manual.examples import examples_in

SECTIONS = [s for s in sections_of(source_of(SOURCE)) if s.title]
WORDS = sorted(kinolab.dynamics.__all__)
WHOLE = next(s for s in SECTIONS if s.title == "A complete machine")
FILE, SESSION, HEAD = examples_in(WHOLE, "python")
MADE_BY_OTHERS = {"Coordinate", "Filtration", "InvolutiveClosure", "SmallTime"}  # never called


def section_of(word: str) -> ManualSection:
    (found,) = (s for s in SECTIONS if (s.level, s.title) == (3, word))
    return found


@pytest.mark.parametrize("word", WORDS)
def test_every_word_has_an_example_that_uses_it(word: str) -> None:
    """If this fails for a new word: give it a heading and an example in manual/machines.md."""
    examples = "".join(examples_in(section_of(word), "python"))
    assert re.search(rf"\b{word}\b", examples)
    assert "assert " in examples


def test_every_entry_is_a_word() -> None:
    assert sorted(s.title for s in SECTIONS if s.level == 3) == WORDS


@pytest.mark.parametrize("word", sorted({*WORDS} - MADE_BY_OTHERS))
def test_every_argument_is_explained(word: str) -> None:
    thing = getattr(kinolab.dynamics, word)
    if inspect.isclass(thing) or inspect.isfunction(thing):
        told = described(section_of(word)).text.partition(")`")[2]
        missing = [
            p for p in inspect.signature(thing).parameters if not re.search(rf"\b{p}\b", told)
        ]
        assert missing == []


@pytest.mark.parametrize(
    "section", [s for s in SECTIONS if s is not WHOLE], ids=lambda section: section.title
)
def test_examples_are_true(section: ManualSection) -> None:
    """Each by itself, after the lines that the page begins with."""
    for example in examples_in(section, "python"):
        exec(HEAD + example, {})


def test_the_complete_machine_is_short_and_needs_nothing_else() -> None:
    names: dict[str, object] = {}
    exec(FILE, names)
    exec(SESSION, names)
    (function,) = (node for node in ast.parse(FILE).body if isinstance(node, ast.FunctionDef))
    assert ast.get_docstring(function)
    assert (function.end_lineno or 0) - function.lineno < 25  # lines


def test_a_word_without_an_example_would_be_noticed() -> None:
    bare = ManualSection(3, "Spring", "A spring.")
    assert "`between`: The two frames." in described(bare).text
    assert examples_in(bare, "python") == []
