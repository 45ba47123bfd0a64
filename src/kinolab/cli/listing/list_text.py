"""Lists as text for a terminal: columns that line up."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from kinolab.cli.listing.data import GROUPS, names_of
from kinolab.cli.listing.planner_entry import PlannerEntry, option_entries, planner_entries
from kinolab.scenario import shared_settings
from kinolab.scenario.toml_text import value_text
from kinolab.settings import Setting

HEADINGS = ("setting", "default", "unit", "range", "meaning")
INDENT = "  "


def listed_as_text(group: str | None, wanted: Sequence[str] = ()) -> str:
    """Return what ``plan list`` says.

    Args:
        group: ``scenarios``, ``systems``, ``planners`` or ``options``; None for the names of all.
        wanted: Names within the group; everything where left out.

    Raises:
        InputError: If nothing in the group has a name.
    """
    if group is None:
        return "\n".join(line for kind in GROUPS for line in group_lines(kind))
    if group == "options":
        return "\n\n".join("\n".join(planner_lines(entry)) for entry in option_entries(wanted))
    if group != "planners":
        return "\n".join(columns(names_of(group, wanted).items()))
    blocks = ["\n".join(planner_lines(entry)) for entry in planner_entries(wanted)]
    shared = "" if wanted else "\n".join(shared_lines())
    return "\n\n".join(filter(None, [*blocks, shared]))


def group_lines(group: str) -> Iterator[str]:
    """Yield a group's heading and, below it, its names with a line about each."""
    yield group
    yield from (INDENT + line for line in columns(names_of(group).items()))


def planner_lines(entry: PlannerEntry) -> Iterator[str]:
    """Yield all that is told about a planner."""
    yield f"{entry.name}: {entry.line}".removesuffix(": ")
    if entry.origin:
        yield f"{INDENT}from {entry.origin}"
    if entry.source:
        yield f"{INDENT}source: {entry.source}"
    yield from setting_lines(entry.settings)


def shared_lines() -> Iterator[str]:
    """Yield the keys that all planners share."""
    yield "further keys of [planner], for every planner"
    yield from setting_lines(shared_settings())


def setting_lines(settings: Sequence[Setting]) -> Iterator[str]:
    """Yield a table of settings; nothing where there are none."""
    if settings:
        yield from (INDENT + line for line in columns([HEADINGS, *setting_rows(settings)]))


def setting_rows(settings: Iterable[Setting]) -> list[tuple[str, str, str, str, str]]:
    """Return name, default, unit, range and meaning of settings."""
    return [
        (entry.name, _default(entry), entry.unit, entry.range, entry.meaning) for entry in settings
    ]


def _default(entry: Setting) -> str:
    return "none" if entry.default is None else value_text(entry.default)


def columns(rows: Iterable[Sequence[str]]) -> list[str]:
    """Return rows of cells as lines in which the columns begin at the same place."""
    table = list(rows)
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in table
    ]
