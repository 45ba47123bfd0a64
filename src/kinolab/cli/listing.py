"""Lists of scenarios, systems, planners and options, as plain data and as aligned text."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from kinolab import systems
from kinolab.cli.planner_entry import PlannerEntry, option_entries, planner_entries
from kinolab.errors import UnknownNameError
from kinolab.scenario import builtin_scenarios, load_scenario, shared_settings
from kinolab.scenario.toml_text import value_text
from kinolab.settings import Setting

HEADINGS = ("setting", "default", "unit", "range", "meaning")
INDENT = "  "

# A line about each entry, by name; kinolab's own planner wins over others of its name.
GROUPS: Mapping[str, Callable[[], dict[str, str]]] = {
    "scenarios": lambda: {
        name: load_scenario(path).title for name, path in builtin_scenarios().items()
    },
    "systems": lambda: {name: systems.summary(name) for name in systems.names()},
    "planners": lambda: {entry.name: entry.line for entry in reversed(planner_entries())},
}


def names_of(group: str, wanted: Sequence[str] = ()) -> dict[str, str]:
    """Return a line about each entry of a group, by name.

    Args:
        group: ``scenarios``, ``systems`` or ``planners``.
        wanted: Names; all if left out.

    Raises:
        UnknownNameError: If a name is not in the group.
    """
    lines = GROUPS[group]()
    for name in wanted:
        if name not in lines:
            raise UnknownNameError(group.removesuffix("s"), name, known=lines)
    return {name: lines[name] for name in sorted(wanted or lines)}


def setting_to_json(entry: Setting) -> dict[str, Any]:
    """Return a setting as plain data."""
    return {**asdict(entry), "range": entry.range}


def planner_to_json(entry: PlannerEntry) -> dict[str, Any]:
    """Return a planner entry as plain data."""
    return {**asdict(entry), "settings": [setting_to_json(item) for item in entry.settings]}


def listed(group: str | None, wanted: Sequence[str] = ()) -> dict[str, list[dict[str, Any]]]:
    """Return what ``plan list`` prints as plain data: a line each, planners with all settings.

    Args:
        group: One of ``GROUPS`` or ``options``; None for the names of all groups.
        wanted: Names within the group; all if left out.

    Raises:
        InputError: If a name is not in the group.
    """
    if group == "planners":
        return {
            group: [planner_to_json(entry) for entry in planner_entries(wanted)],
            "shared_settings": [setting_to_json(entry) for entry in shared_settings()],
        }
    if group == "options":
        return {group: [planner_to_json(entry) for entry in option_entries(wanted)]}
    return {
        kind: [{"name": name, "summary": line} for name, line in names_of(kind, wanted).items()]
        for kind in ([group] if group else GROUPS)
    }


def listed_as_text(group: str | None, wanted: Sequence[str] = ()) -> str:
    """Return what ``plan list`` prints.

    Args:
        group: ``scenarios``, ``systems``, ``planners`` or ``options``; None for the names of all.
        wanted: Names within the group; all if left out.

    Raises:
        InputError: If a name is not in the group.
    """
    if group is None:
        return "\n".join(
            line for kind in GROUPS for line in [kind, *indented(names_of(kind).items())]
        )
    if group == "options":
        return "\n\n".join("\n".join(planner_lines(entry)) for entry in option_entries(wanted))
    if group != "planners":
        return "\n".join(columns(names_of(group, wanted).items()))
    blocks = ["\n".join(planner_lines(entry)) for entry in planner_entries(wanted)]
    further = ["further keys of [planner], for every planner", *setting_lines(shared_settings())]
    shared = "" if wanted else "\n".join(further)
    return "\n\n".join(filter(None, [*blocks, shared]))


def planner_lines(entry: PlannerEntry) -> Iterator[str]:
    """Yield the lines about a planner."""
    yield f"{entry.name}: {entry.line}".removesuffix(": ")
    if entry.origin:
        yield f"{INDENT}from {entry.origin}"
    if entry.source:
        yield f"{INDENT}source: {entry.source}"
    yield from setting_lines(entry.settings)


def setting_lines(settings: Sequence[Setting]) -> list[str]:
    """Return a table of settings; empty if there are none."""
    return indented([HEADINGS, *setting_rows(settings)]) if settings else []


def indented(rows: Iterable[Sequence[str]]) -> list[str]:
    """Return rows of cells as indented, aligned lines."""
    return [INDENT + line for line in columns(rows)]


def setting_rows(settings: Iterable[Setting]) -> Iterator[tuple[str, str, str, str, str]]:
    """Yield name, default, unit, range and meaning of settings."""
    for entry in settings:
        default = "none" if entry.default is None else value_text(entry.default)
        yield entry.name, default, entry.unit, entry.range, entry.meaning


def columns(rows: Iterable[Sequence[str]]) -> list[str]:
    """Return rows of cells as lines with aligned columns."""
    table = list(rows)
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in table
    ]
