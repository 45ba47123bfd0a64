"""Planners of installed packages, registered in the entry-point group ``kinolab.planners``."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from importlib.metadata import EntryPoint, entry_points

from kinolab.errors import InputError, Mistake
from kinolab.scenario.user_code import blamed
from kinolab.search.planner import AbstractPlanner
from kinolab.search.plugins.planner_class import planner_class

GROUP = "kinolab.planners"


def registered() -> dict[str, list[EntryPoint]]:
    """Return registered entry points by name, several per name if shared; imports nothing."""
    found: dict[str, list[EntryPoint]] = {}
    for entry in sorted(entry_points(group=GROUP), key=lambda entry: (entry.name, entry.value)):
        found.setdefault(entry.name, []).append(entry)
    return found


def package_of(entry: EntryPoint) -> str:
    """Return the package that registers a planner, with its version."""
    if entry.dist is None or not entry.dist.name:
        return f"a package without a name ({entry.value})"
    return f"{entry.dist.name} {entry.dist.version}"


def class_of(
    entries: Sequence[EntryPoint], where: str, taken: Collection[str]
) -> type[AbstractPlanner]:
    """Import a registered planner.

    Args:
        entries: All entry points registered under its name.
        where: Location for error messages.
        taken: Names of kinolab's own planners, which are reserved.

    Raises:
        InputError: If importing fails, or the registered object is no planner of that name.
    """
    entry, name = entries[0], entries[0].name
    packages = " and ".join(dict.fromkeys(map(package_of, entries)))
    if name in taken:
        what = f"{packages} registers a planner {name!r}, as kinolab does; kinolab's is used."
        raise InputError([Mistake(where, what, "Let the package choose another name.")])
    if len(entries) > 1:
        what = f"{packages} register a planner {name!r} each."
        raise InputError([Mistake(where, what, "Uninstall all but one.")])
    remedy = f"Repair or uninstall {packages}."
    with blamed(f"importing {entry.value} of {packages}", where, remedy=remedy):
        found = entry.load()
    planner = planner_class(found, f"{entry.value} of {packages}", where, taken)
    if planner.name != name:
        what = f"{packages} registers {entry.value} as {name!r}, but it calls itself"
        remedy = "A planner has one name: its class's and its entry point's."
        raise InputError([Mistake(where, f"{what} {planner.name!r}.", remedy)])
    return planner
