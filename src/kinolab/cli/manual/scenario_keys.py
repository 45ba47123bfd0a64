"""The page on scenarios: each key of the schema with what it takes, its default and an example."""

from __future__ import annotations

import re
from collections.abc import Iterator

from kinolab.cli.manual.sections import ManualSection, sections_of, source_of, table
from kinolab.scenario import shared_settings
from kinolab.scenario.issues import KeyPath
from kinolab.scenario.locations import NAME_TABLES, fields_of, keys_of, section_at, wanted_at
from kinolab.scenario.schema import Scenario

SOURCE = "scenarios.md"
TOP = "The two lines at the top"
FREE = "NAME"  # stands for the name of a coordinate, a setting, …
HEAD = ("key", "what it takes", "default", "meaning")
KEYS = re.compile(r"(?:^- `[^`]+`: .*\n(?:  .*\n)*)+", re.MULTILINE)
KEY = re.compile(r"^- `([^`]+)`: (.*(?:\n  .*)*)", re.MULTILINE)
DEFAULT = re.compile(r"(.*?)(?: \(default (.*)\))?")


def page() -> str:
    """Return the page on scenarios."""
    return "\n".join(str(told(section)) for section in sections_of(source_of(SOURCE)))


def path_of(section: ManualSection) -> KeyPath | None:
    """Return where a section of the page stands in a scenario; None if it is prose."""
    if section.level != 3:
        return None
    return () if section.title == TOP else tuple(section.title.strip("[]").split("."))


def meanings(section: ManualSection) -> dict[str, str]:
    """Return what each key of a section means, by its name; what the schema says comes first."""
    given = {key: " ".join(text.split()) for key, text in KEY.findall(f"{section.text}\n")}
    if path_of(section) == ("planner",):
        given = {entry.name: entry.meaning for entry in shared_settings()} | given
    return given


def told(section: ManualSection) -> ManualSection:
    """Return a section with a table of its keys in the place of their list."""
    path = path_of(section)
    if path is None:
        return section
    written = table(HEAD, list(rows(path, meanings(section))))
    text = KEYS.sub(lambda _: f"{written}\n", f"{section.text}\n", count=1)
    return ManualSection(section.level, section.title, text)


def rows(path: KeyPath, given: dict[str, str]) -> Iterator[tuple[str, ...]]:
    """Yield a row about each key, in the order of the schema, and about free ones."""
    order = [*schema_keys(path), FREE]
    for key in sorted(given, key=order.index):
        if path in NAME_TABLES:
            yield f"`{key}`", wanted_at(path), "–", given[key]
            continue
        phrase, default = taken(path, key)
        yield f"`{key}`", phrase, default or "–", given[key]


def schema_keys(path: KeyPath) -> list[str]:
    """Return the keys that the schema has in a section; of the top those that are no sections."""
    section = section_at(path)
    keys = [] if section is None else keys_of(section)
    return ["schema", "title"] if section is Scenario else keys


def taken(path: KeyPath, key: str) -> tuple[str, str]:
    """Return what a key takes, in words, and its default; empty where it has none."""
    found = DEFAULT.fullmatch(wanted_at((*path, key)))
    phrase, default = (found[1], f"`{found[2]}`" if found[2] else "") if found else ("", "")
    if (*path, key) in NAME_TABLES:
        phrase = f"a table, by name: {phrase}"
    section = section_at(path)
    field = fields_of(section).get(key) if section else None
    return phrase, "required" if field and field.is_required() else default
