"""The page on the files of a run: what every file, column and number is."""

from __future__ import annotations

import ast
import re
from importlib.resources import files

from kinolab.cli.manual.sections import sections_of, source_of, table

ATTRIBUTES = re.compile(r"^\{attributes of kinolab\.([\w.]+)\.(\w+)\}$", re.MULTILINE)
ENTRY = re.compile(r"^    (\w+): (.*(?:\n     .*)*)", re.MULTILINE)


def page() -> str:
    """Return the page on the files of a run."""
    text = ATTRIBUTES.sub(lambda found: attributes(found[1], found[2]), source_of("files.md"))
    return "\n".join(map(str, sections_of(text)))


def attributes(module: str, name: str) -> str:
    """Return the attributes of a class as a table, from its docstring.

    The file is read, not imported: some of these classes stand among compiled code.
    """
    source = files("kinolab").joinpath(f"{module.replace('.', '/')}.py").read_text(encoding="utf-8")
    (kind,) = (n for n in ast.parse(source).body if isinstance(n, ast.ClassDef) and n.name == name)
    told = (ast.get_docstring(kind) or "").partition("Attributes:\n")[2]
    told = re.sub(r"\bNone\b", "`null`", told.replace("``", "`"))  # as JSON has it
    entries = ENTRY.findall(re.split(r"\n\n(?=\S)", told)[0])
    return table(("key", "content"), [(f"`{k}`", " ".join(words.split())) for k, words in entries])
