"""What there is to choose from, as plain data."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from kinolab import systems
from kinolab.cli.listing.planner_entry import PlannerEntry, option_entries, planner_entries
from kinolab.errors import UnknownNameError
from kinolab.scenario import builtin_scenarios, load_scenario, shared_settings
from kinolab.settings import Setting


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
