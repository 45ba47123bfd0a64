"""Scenarios from Python: as tables, with a machine as an object, and changed."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinolab.errors import Mistake
from kinolab.scenario import (
    Origin,
    Override,
    Scenario,
    apply_changes,
    apply_overrides,
    check_changed,
    write_scenario,
)

if TYPE_CHECKING:
    from kinolab.dynamics import System

NAME = "scenario"  # of one that has no file
OBJECT = {"file": "machine.json"}  # what [system] says of a machine that is an object
Read = tuple[Scenario | None, list[Mistake]]


def read_table(table: Mapping[str, Any], *, overrides: Sequence[str] = ()) -> Read:
    """Read a scenario from a table, and list its mistakes instead of raising them.

    Args:
        table: Keys and values as in a file; ``system`` may be a System or a name, ``schema`` and
            ``title`` may be left out. Relative paths start at the working directory.
        overrides: ``KEY=VALUE`` texts that replace keys.
    """
    document: dict[str, Any] = {"schema": 1, "title": NAME, **plain(table)}
    machine = _machine_in(document)
    applied, mistakes = apply_overrides(document, overrides)
    return check_changed(document, Origin(Path.cwd() / NAME, applied, machine), mistakes)


def read_changed(scenario: Scenario, changes: Mapping[str, Any], by: str = "replace") -> Read:
    """Read a scenario with some keys changed, and list its mistakes instead of raising them.

    Args:
        scenario: What to change.
        changes: Values by dotted key, such as ``start.x``; lists count from 1.
        by: What was called, for messages.
    """
    document, values = tomllib.loads(write_scenario(scenario)), plain(changes)
    given = _machine_in(values)
    applied, mistakes = apply_changes(document, values, by)
    machine = given or scenario.origin.machine
    if any(o.path[0] == "system" and o.path[1:2] != ("parameters",) for o in applied):
        machine = given  # another machine is named
    origin = replace(scenario.origin, overrides=applied, machine=machine)
    return check_changed(document, origin, mistakes)


def read_with_obstacle(scenario: Scenario, obstacle: Mapping[str, Any]) -> Read:
    """Read a scenario with one more obstacle, and list its mistakes instead of raising them."""
    document = tomllib.loads(write_scenario(scenario))
    entries = document.setdefault("world", {}).setdefault("obstacle", [])
    added = Override("", ("world", "obstacle", len(entries)), by="with_obstacle")
    entries.append(plain(obstacle))
    return check_changed(document, replace(scenario.origin, overrides=(added,)), [])


def plain(value: Any) -> Any:
    """Return a value as TOML would have it: lists for tuples and arrays, text for paths."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, Path):
        return str(value)
    return value.tolist() if hasattr(value, "tolist") else value


def _machine_in(document: dict[str, Any]) -> System | None:
    """Take a machine that is an object out of a document, and say so there; a text is a name."""
    given = document.get("system")
    if isinstance(given, str):
        document["system"] = {"name": given}
    if given is None or isinstance(given, Mapping | str | int | float | list):
        return None
    from kinolab.dynamics import System
    from kinolab.dynamics.language.mechanism import Mechanism

    if not isinstance(given, Mechanism):
        return None
    document["system"] = dict(OBJECT)
    return System.of(given)
