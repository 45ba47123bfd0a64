"""The page on the files of a run: what every file, column and number is."""

from __future__ import annotations

import inspect
import re
from importlib import import_module

from kinolab.manual.sections import sections_of, source_of, table
from kinolab.runs.folder import PLOTS

SOURCE = "files.md"
ATTRIBUTES = re.compile(r"^\{attributes of ([\w.]+)\.(\w+)\}$", re.MULTILINE)
PLOTTED = "{plots}"
ENTRY = re.compile(r"^    (\w+): (.*(?:\n     .*)*)", re.MULTILINE)


def files_page() -> str:
    """Return the page on the files of a run."""
    text = ATTRIBUTES.sub(lambda found: attributes(found[1], found[2]), source_of(SOURCE))
    text = text.replace(PLOTTED, ", ".join(f"`{name}`" for name in PLOTS) + ".")
    return "\n".join(map(str, sections_of(text)))


def attributes(module: str, name: str) -> str:
    """Return the attributes of a class as a table, from its docstring."""
    told = inspect.getdoc(getattr(import_module(module), name)) or ""
    entries = ENTRY.findall(re.split(r"\n\n(?=\S)", told.partition("Attributes:\n")[2])[0])
    rows = [(f"`{key}`", _plain(words)) for key, words in entries]
    return table(("key", "content"), rows)


def _plain(words: str) -> str:
    """Return what a docstring says of an attribute as the report has it: in JSON None is null."""
    return re.sub(r"\bNone\b", "`null`", " ".join(words.split()).replace("``", "`"))
