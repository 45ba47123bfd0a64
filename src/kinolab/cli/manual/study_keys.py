"""The page on studies: the keys of their files, and the columns of their tables."""

from __future__ import annotations

import re

from kinolab.cli.manual.sections import sections_of, source_of, table
from kinolab.scenario.locations import fields_of
from kinolab.scenario.toml_text import value_text
from kinolab.studies import study_file
from kinolab.studies.columns import COLUMNS, KINDS

KEYS = re.compile(r"^\{keys of (\w+)\}$", re.MULTILINE)


def page() -> str:
    """Return the page on studies."""
    text = KEYS.sub(lambda found: keys_of_table(found[1]), source_of("benchmarking.md"))
    rows = [
        (f"`{one.name}`", KINDS[one.kind], "yes" if one.timed else "", one.meaning)
        for one in COLUMNS
    ]
    text = text.replace("{columns}", table(("column", "type", "time", "meaning"), rows))
    return "\n".join(map(str, sections_of(text)))


def keys_of_table(name: str) -> str:
    """Return the keys of a table of a study's file, with their defaults and meanings."""
    model: type[study_file.Table] = getattr(study_file, name)
    rows = []
    for key, field in fields_of(model).items():
        plain = isinstance(field.default, bool | int | str) and field.default != ""
        default = f"`{value_text(field.default)}`" if plain else ""
        rows.append((f"`{key}`", str(field.description), default))
    return table(("key", "meaning", "default"), rows)
