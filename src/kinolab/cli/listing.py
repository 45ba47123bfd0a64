"""What there is to choose from, as plain data and as text whose columns line up."""

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


def scenario_titles() -> dict[str, str]:
    """Return the title of every scenario that comes with kinolab, by name."""
    return {name: load_scenario(path).title for name, path in builtin_scenarios().items()}


def system_summaries() -> dict[str, str]:
    """Return a line about every system that comes with kinolab, by name."""
    return {name: systems.summary(name) for name in systems.names()}


def planner_summaries() -> dict[str, str]:
    """Return a line about every planner, by name; kinolab's own where another has its name."""
    return {entry.name: entry.line for entry in reversed(planner_entries())}


def names_of(group: str, wanted: Sequence[str] = ()) -> dict[str, str]:
    """Return a line about everything in a group, by name.

    Args:
        group: ``scenarios``, ``systems`` or ``planners``.
        wanted: Names; everything where left out.

    Raises:
        UnknownNameError: If nothing in the group has a name.
    """
    lines = GROUPS[group]()
    for name in wanted:
        if name not in lines:
            raise UnknownNameError(group.removesuffix("s"), name, known=lines)
    return {name: lines[name] for name in sorted(wanted or lines)}


def planner_to_json(entry: PlannerEntry) -> dict[str, Any]:
    """Return what is told about a planner as plain data."""
    return {**asdict(entry), "settings": [setting_to_json(item) for item in entry.settings]}


def setting_to_json(entry: Setting) -> dict[str, Any]:
    """Return a setting as plain data."""
    return {**asdict(entry), "range": entry.range}


GROUPS: Mapping[str, Callable[[], dict[str, str]]] = {
    "scenarios": scenario_titles,
    "systems": system_summaries,
    "planners": planner_summaries,
}


def listed(group: str | None, wanted: Sequence[str] = ()) -> dict[str, list[dict[str, Any]]]:
    """Return what ``plan list`` says as plain data: names with a line each, planners with all.

    Args:
        group: One of ``GROUPS`` or ``options``; None for the names of all groups.
        wanted: Names within the group; everything where left out.

    Raises:
        InputError: If nothing in the group has a name.
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
