"""What can still be understood of a scenario with mistakes, so that the rest is checked too.

A user should not mend a typing error only to learn of a missing mesh next. What is broken is taken
out, and what is left can be held against the machine and the files.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable
from typing import Any

from pydantic import ValidationError

from kinolab.scenario.issues import Issue, KeyPath, Origin
from kinolab.scenario.schema import Scenario, SystemSection

STAND_IN = {"sphere": 1.0}  # keeps the count of obstacles, on which messages rely


def parse_partially(
    document: dict[str, Any], issues: Iterable[Issue], origin: Origin
) -> Scenario | None:
    """Return the scenario without its broken parts; None where too little is left.

    Its system has neither a name nor a file where that section is among the broken parts.
    """
    try:
        rest = copy.deepcopy(document)
    except RecursionError:
        return None
    broken = [issue.path for issue in issues]
    system = rest.get("system")
    sources = (("system",), ("system", "name"), ("system", "file"))
    unknown = not isinstance(system, dict) or any(path in sources for path in broken)
    rest |= {"schema": 1, "title": "untitled", "system": {"name": "unknown"} if unknown else system}
    for path in sorted(broken, key=len, reverse=True):
        _take_out(rest, path)
    for _ in range(5):  # taking something out may reveal what rests on it
        try:
            scenario = Scenario.model_validate(rest)
        except ValidationError as error:
            for line in error.errors(include_url=False, include_input=False):
                _take_out(rest, tuple(line["loc"]))
            continue
        if unknown:
            nameless = SystemSection.model_construct(name=None, file=None, parameters={})
            scenario = scenario.model_copy(update={"system": nameless})
        return scenario.located(origin)
    return None


def _take_out(document: dict[str, Any], path: KeyPath) -> None:
    """Remove what stands at a path; an obstacle is replaced, a list is cut at its broken entry."""
    if path[:2] == ("world", "obstacle") and len(path) > 2:
        obstacles = document["world"]["obstacle"]
        if isinstance(obstacles, list) and isinstance(path[2], int) and path[2] < len(obstacles):
            obstacles[path[2]] = dict(STAND_IN)
        return
    holder: Any = document
    for part in path[:-1]:
        if isinstance(holder, list) and isinstance(part, int):
            del holder[part:]
            return
        if not isinstance(holder, dict) or not isinstance(holder.get(part), dict | list):
            return
        holder = holder[part]
    if path and isinstance(holder, dict) and path[-1] not in ("schema", "title", "system"):
        holder.pop(path[-1], None)
    elif path and isinstance(holder, list) and isinstance(path[-1], int):
        del holder[path[-1] :]
