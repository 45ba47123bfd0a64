"""From a path or a built-in name to a checked scenario."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from kinolab.errors import InputError, Mistake
from kinolab.scenario.file_lookup import read_text, scenario_path
from kinolab.scenario.issues import Issue, KeyPath, Origin
from kinolab.scenario.locations import mistake_at
from kinolab.scenario.messages import explain
from kinolab.scenario.overrides import apply_overrides
from kinolab.scenario.partial_parse import parse_partially
from kinolab.scenario.rules import document_issues, system_issues
from kinolab.scenario.schema import ALL, GoalSection, MachineTables, Scenario
from kinolab.scenario.toml_text import (
    long_key,
    shortened,
    shown,
    values_in,
)
from kinolab.scenario.user_code import python_reference
from kinolab.untrusted import ELEMENTS, refuse_many

MISTAKE_LIMIT = 100  # nobody reads more, and every one of them takes time to word
_BEGINNING = 'Begin with schema = 1, title = "…" and a [system] section.'


def load_scenario(source: str | Path, *, overrides: Sequence[str] = ()) -> Scenario:
    """Read a scenario and check everything that can be checked without its machine.

    Args:
        source: A path, or the name of a built-in scenario. Text with a path separator or
            ending in .toml is a path; other text is a built-in name first and then a path.
        overrides: ``KEY=VALUE`` each, applied in order before the check. The key is dotted
            and counts entries of lists from 1; the value is TOML, or else text.

    Raises:
        InputError: If there is no such file or anything in it is wrong; ``.mistakes`` has
            all that was found.
    """
    return sound(*read_scenario(source, overrides=overrides))


def sound(scenario: Scenario | None, mistakes: Sequence[Mistake]) -> Scenario:
    """Return a scenario in which no mistakes were found.

    Raises:
        InputError: With all that were found.
    """
    if mistakes or scenario is None:
        raise InputError(mistakes)
    return scenario


def read_scenario(
    source: str | Path, *, overrides: Sequence[str] = ()
) -> tuple[Scenario | None, list[Mistake]]:
    """Read a scenario and list its mistakes instead of raising them.

    Returns:
        The scenario, or what is left of it without its broken parts, or None; and the mistakes.

    Raises:
        InputError: If there is no such file or it is not TOML.
    """
    path = scenario_path(source)
    if path.suffix == ".py" or python_reference(str(source)):
        remedy = f'A scenario names it, [system] file = "{path.name}"; `plan new` writes both.'
        raise InputError([Mistake(str(source), "this is Python code, not a scenario.", remedy)])
    text = read_text(path)
    if not text.strip():
        raise InputError([Mistake(path.name, "the file is empty.", _BEGINNING)])
    document = toml_document(text, path.name, "Draw the obstacles as one mesh.")
    if not document:
        raise InputError([Mistake(path.name, "the file holds no keys.", _BEGINNING)])
    return check_document(document, path, overrides=overrides)


def scenario_from(
    document: dict[str, Any], path: Path, *, overrides: Sequence[str] = ()
) -> Scenario:
    """Return the scenario of keys that were never in a file.

    Args:
        document: Keys and values as TOML would have them.
        path: Where relative paths start, and what mistakes are reported for.
        overrides: As for ``load_scenario``.

    Raises:
        InputError: If anything in it is wrong.
    """
    return sound(*check_document(document, path, overrides=overrides))


def check_document(
    document: dict[str, Any], path: Path, *, overrides: Sequence[str] = ()
) -> tuple[Scenario | None, list[Mistake]]:
    """Return what ``scenario_from`` does, listing mistakes instead of raising them.

    Returns:
        The scenario, or what is left of it without its broken parts, or None; and the mistakes.
    """
    applied, mistakes = apply_overrides(document, overrides)
    return check_changed(document, Origin(path, applied), mistakes)


def check_changed(
    document: dict[str, Any], origin: Origin, mistakes: list[Mistake]
) -> tuple[Scenario | None, list[Mistake]]:
    """Return what ``check_document`` does, of a document that was changed already.

    Args:
        document: Keys and values as TOML would have them.
        origin: Where it is from, with what was changed.
        mistakes: In the changes; they come first.
    """
    tables = document.get("machine")
    document, found = _side_by_side(document)
    if tables and not found:
        origin = replace(origin, machines=tuple(document["system"]["machines"]))
    mistakes += [mistake_at(issue, origin) for issue in found]
    document = _divided(document)
    issues, scenario = document_issues(document), None
    try:
        scenario = Scenario.model_validate(document).located(origin)
    except ValidationError as error:
        issues = explain(error, document, MISTAKE_LIMIT) + issues
    issues = _in_reading_order(issues[: MISTAKE_LIMIT + 1], document)
    if found:  # what is left of several machines would be held against the others' names
        scenario = None
    elif issues:
        scenario = parse_partially(document, issues, origin)
    mistakes += [mistake_at(issue, origin) for issue in issues]
    return scenario, readable(mistakes, origin)


def _divided(document: dict[str, Any]) -> dict[str, Any]:
    """Return a document with one [goal]: of several [[goal]], those before are on the way."""
    goals = document.get("goal")
    if not (isinstance(goals, list) and goals and all(isinstance(one, dict) for one in goals)):
        return document
    *on_the_way, last = goals
    if any(one.get("order") == "any" for one in goals):
        last = {**last, "order": "any"}
    earlier = document.get("via", [])
    rest = {key: value for key, value in document.items() if key not in ("via", "goal")}
    return {**rest, "via": [*earlier, *on_the_way], "goal": last}


def _side_by_side(document: dict[str, Any]) -> tuple[dict[str, Any], list[Issue]]:
    """Return a document with one [system], [start] and [goal]: those of all [[machine]] entries.

    A key of one machine has the machine's name before it there, as have its coordinates.
    """
    machines = document.get("machine")
    if machines is None:
        return document, []
    entries = machines if isinstance(machines, list) else [machines]
    issues = [*_entry_issues(entries)]
    broken = [issue.path for issue in issues]
    sound = [_without(one, broken, k) for k, one in enumerate(entries) if isinstance(one, dict)]
    named: dict[str, dict[str, Any]] = {one["name"]: one for one in sound if "name" in one}
    if len(entries) < 2:
        issues.append(Issue(("machine",), "it is the only one.", "Write [system], or another one."))
    made = {key: value for key, value in document.items() if key != "machine"}
    for key in ("system", "start", "goal"):
        if key in made:
            what = f"[{key}] stands beside [[machine]], each of which has its own."
            issues.append(Issue((key,), what, "Leave one of the two out."))
    made["system"] = {"machines": {name: _table(one, "system") for name, one in named.items()}}
    for key in ("bounds", "metric", "start"):
        own = {f"{name}_{k}": v for name, one in named.items() for k, v in _table(one, key).items()}
        made[key] = {**_table(made, key), **own}
    made["planner"] = {"name": "prioritized", **_table(made, "planner")}
    made["goal"] = _common_goal({name: _table(one, "goal") for name, one in named.items()}, issues)
    return made, issues


def _entry_issues(entries: list[Any]) -> Iterator[Issue]:
    """Yield what is wrong with the [[machine]] tables, each by itself and their names together."""
    whole = {"machine": entries}
    try:
        MachineTables.model_validate(whole)
    except ValidationError as error:
        yield from explain(error, whole, MISTAKE_LIMIT)
    taken: dict[str, int] = {}
    for k, entry in enumerate(entries):
        if not isinstance(entry, dict):
            continue
        if isinstance(name := entry.get("name"), str):
            if what := _name_fault(name, taken):
                yield Issue(("machine", k, "name"), what, 'Write name = "left", for example.')
            taken.setdefault(name, k + 1)
        for issue in system_issues(system := _table(entry, "system"), system.get("file")):
            if system or isinstance(entry.get("system"), dict):
                yield replace(issue, path=("machine", k, "system", *issue.path))


def _name_fault(name: str, taken: Mapping[str, int]) -> str:
    """Say what is wrong with the name of a [[machine]]; nothing is where all is well."""
    if not name.isidentifier():
        return f"{shown(name)} has other characters than letters, digits and _, or begins with one."
    return f"machine {taken[name]} is called {shown(name)}, too." if name in taken else ""


def _without(entry: dict[str, Any], broken: Collection[KeyPath], k: int) -> dict[str, Any]:
    """Return a [[machine]] without the keys in which something is wrong."""
    wrong = {path[2] for path in broken if path[:2] == ("machine", k) and len(path) > 2}
    return {key: value for key, value in entry.items() if key not in wrong}


def _common_goal(goals: dict[str, dict[str, Any]], issues: list[Issue]) -> dict[str, Any]:
    """Return the goal that all machines reach theirs, which are alike in what is of all."""
    made: dict[str, Any] = {"tolerance": {}}
    for k, (name, goal) in enumerate(goals.items()):
        for key, value in goal.items():
            if key == "tolerance":
                own = value if isinstance(value, dict) else {ALL: value}
                made[key] |= {f"{name}_{n}": v for n, v in own.items()}
            elif key == "at_rest":
                made[key] = [*made.get(key, []), *([name] if value else [])]
            elif key in ("point", "direction") and isinstance(value, list):
                placed = [{**p, "body": f"{name}_{p.get('body')}"} for p in value]
                made[key] = [*made.get(key, []), *placed]
            elif key in GoalSection.model_fields:
                if made.setdefault(key, value) != value:
                    what = f"{key} is not what another machine's goal says."
                    issues.append(Issue(("machine", k, "goal", key), what, "Write the same."))
            else:
                made[f"{name}_{key}"] = value
    if len(made.get("at_rest", ())) in (0, len(goals)):
        made["at_rest"] = bool(made.get("at_rest"))
    return made


def _table(entry: dict[str, Any], key: str) -> dict[str, Any]:
    value = entry.get(key, {})
    return value if isinstance(value, dict) else {}


def readable(mistakes: list[Mistake], origin: Origin) -> list[Mistake]:
    """Return mistakes, or the first of very many."""
    if len(mistakes) < MISTAKE_LIMIT:
        return mistakes
    rest = Mistake(origin.file.name, "there may be more mistakes than these.", "Mend these first.")
    return [*mistakes[:MISTAKE_LIMIT], rest]


def _in_reading_order(issues: list[Issue], document: dict[str, Any]) -> list[Issue]:
    """Sort findings as their places stand in the document; what is missing comes last."""

    def places(issue: Issue) -> list[int]:
        holder: Any = document
        order = []
        for part in issue.path:
            several = range(len(holder)) if isinstance(holder, list) else ()
            keys: list[Any] = list(holder if isinstance(holder, dict) else several)
            order.append(keys.index(part) if part in keys else len(keys))
            holder = holder[part] if part in keys else None
        return order

    return sorted(issues, key=places)


def toml_document(text: str, label: str, fewer: str) -> dict[str, Any]:
    """Parse the text of a file; ``fewer`` is what helps where it holds too many values.

    Raises:
        InputError: If it is not TOML, or has too many values or too long keys.
    """
    if line := long_key(text):
        what = f"a key has more than {ELEMENTS['parts of a key']} parts with dots between them."
        raise InputError([Mistake(f"{label} line {line}", what, "Shorten it.")])
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError([_not_toml(label, text, error)]) from None
    refuse_many(values_in(document), "values", label, fewer)
    return document


def _not_toml(label: str, text: str, error: Exception) -> Mistake:
    """Say where TOML broke, in tomllib's words, and show the line."""
    remedy = 'TOML has key = value, "text" in quotes, [lists] and { tables = "closed" }.'
    if isinstance(error, RecursionError):
        return Mistake(label, "its lists or tables are nested too deep.", remedy)
    if not isinstance(error, tomllib.TOMLDecodeError):  # Python reads at most 4300 digits
        return Mistake(label, "one of its numbers is too long to read.", "Shorten the number.")
    said, _, place = str(error).partition(" (at ")
    said = said[:1].lower() + said[1:]
    numbers = re.fullmatch(r"line (\d+), column (\d+)\)", place)
    if not numbers:
        line = text.rstrip().count("\n") + 1
        end = f"{label} line {line}" if place else label
        return Mistake(end, f"this is not TOML: {said}{' (at the end)' if place else ''}.", remedy)
    line = int(numbers[1])
    reads = shortened(text.replace("\r\n", "\n").split("\n")[line - 1].strip())
    where = f"{label} line {line}, column {numbers[2]}"
    return Mistake(where, f"this is not TOML: {said}. The line reads {reads!r}.", remedy)
