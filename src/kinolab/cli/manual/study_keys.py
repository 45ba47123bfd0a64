"""The page on studies: the keys of their files, and the columns of their tables."""

from __future__ import annotations

import re

from kinolab.cli.manual.sections import sections_of, source_of, table
from kinolab.scenario.toml_text import value_text
from kinolab.studies import study_file
from kinolab.studies.columns import COLUMNS

SOURCE = "benchmarking.md"
KEYS = re.compile(r"^\{keys of (\w+)\}$", re.MULTILINE)
KINDS = {
    "text": "string",
    "whole": "int64",
    "number": "double",
    "truth": "bool",
    "pairs": "list of 2 doubles each",
}


def studies_page() -> str:
    """Return the page on studies."""
    text = KEYS.sub(lambda found: keys_of_table(found[1]), source_of(SOURCE))
    text = text.replace("{columns}", columns_table())
    return "\n".join(map(str, sections_of(text)))


def keys_of_table(name: str) -> str:
    """Return the keys of a table of a study's file, with their defaults and meanings."""
    model: type[study_file.Table] = getattr(study_file, name)
    rows = []
    for field_name, field in model.model_fields.items():
        if field_name == "path":
            continue
        plain = isinstance(field.default, bool | int | str) and field.default != ""
        default = f"`{value_text(field.default)}`" if plain else ""
        rows.append((f"`{field.alias or field_name}`", str(field.description), default))
    return table(("key", "meaning", "default"), rows)


def columns_table() -> str:
    """Return the columns of a study's table, with their types and meanings."""
    rows = [
        (f"`{one.name}`", KINDS[one.kind], "yes" if one.timed else "", one.meaning)
        for one in COLUMNS
    ]
    return table(("column", "type", "time", "meaning"), rows)
