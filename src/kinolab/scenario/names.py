"""Names in a scenario against the names that its machine has, and angles against its angles."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from kinolab.errors import Mistake
from kinolab.scenario.angles import WrittenAngle
from kinolab.scenario.issues import Issue, KeyPath
from kinolab.scenario.locations import keys_of, mistake_at
from kinolab.scenario.rules import unknown_key
from kinolab.scenario.schema import ALL, DirectionGoal, GoalSection, KeepOut, PointGoal, Scenario
from kinolab.scenario.toml_text import shown


def check_names(
    scenario: Scenario,
    coordinates: Sequence[str],
    rates: Sequence[str],
    parameters: Sequence[str],
    bodies: Sequence[str],
    inputs: Sequence[str] = (),
    known_of: Mapping[str, str] | None = None,
) -> list[Mistake]:
    """List every name that the machine does not have, with what is known of it, or the nearest."""
    state = [*coordinates, *rates]
    issues = [
        *_unknown(("system", "parameters"), scenario.system.parameters, parameters, "parameter"),
        *_unknown(("bounds",), scenario.bounds, [*state, *inputs], "coordinate, rate or input"),
        *_unknown(("metric",), scenario.metric, state),
        *_unknown(("start",), scenario.start, state),
    ]
    for place, goal in scenario.goal_tables.items():
        issues += _unknown(place, goal.values, [*state, *keys_of(GoalSection)])
        tolerances = goal.tolerance if isinstance(goal.tolerance, dict) else {}
        begun = {
            k for k in tolerances if k.endswith(ALL) and any(s.startswith(k[:-1]) for s in state)
        }
        tolerances = {key: value for key, value in tolerances.items() if key not in begun}
        issues += _unknown((*place, "tolerance"), tolerances, state)
    issues += [
        *(unknown_key(path, b, bodies, "body") for path, b in _bodies(scenario) if b not in bodies),
    ]
    known_of = known_of or {}
    told = ((issue, known_of.get(str(issue.path[-1]))) for issue in issues)
    return [
        mistake_at(Issue(issue.path, known) if known else issue, scenario.origin)
        for issue, known in told
    ]


def check_angles(scenario: Scenario, units: Mapping[str, str]) -> list[Mistake]:
    """List the angles that were written as text where something else is meant.

    Args:
        scenario: What was read.
        units: Of the machine's coordinates, rates, inputs and references, by name.
    """
    issues = []
    for path, angle in _written_angles(scenario):
        name = str(path[-1] if isinstance(path[-1], str) else path[-2])
        unit = units.get(name, angle.unit)  # an unknown name is a mistake of its own
        if unit != angle.unit and not (angle.unit == "" and unit in ("rad", "rad/s")):
            kind = "a rate" if angle.unit == "rad/s" else "an angle"
            measure = f"is in {unit}" if unit else "has no unit"
            what = f"{shown(angle.text)} is {kind}, but {name} {measure}."
            issues.append(Issue(path, what, f"Give a number{f' [{unit}]' if unit else ''}."))
    return [mistake_at(issue, scenario.origin) for issue in issues]


def _written_angles(scenario: Scenario) -> Iterator[tuple[KeyPath, WrittenAngle]]:
    """Yield the angles that stand in tables by names of the machine, each with its place."""
    tables: dict[KeyPath, Mapping[str, object]] = {
        ("bounds",): scenario.bounds,
        ("start",): scenario.start,
    }
    for path, goal in scenario.goal_tables.items():
        tables[path] = goal.values
        tables[*path, "tolerance"] = goal.tolerance if isinstance(goal.tolerance, dict) else {}
    for place, table in tables.items():
        for name, value in table.items():
            for k, entry in enumerate(value if isinstance(value, tuple) else ()):
                if isinstance(entry, WrittenAngle):
                    yield (*place, name, k), entry
            if isinstance(value, WrittenAngle):
                yield (*place, name), value


def _unknown(
    path: KeyPath, names: Iterable[str], known: Sequence[str], kind: str = "coordinate or rate"
) -> list[Issue]:
    return [unknown_key((*path, name), name, known, kind) for name in names if name not in known]


def _bodies(scenario: Scenario) -> list[tuple[KeyPath, str]]:
    """Every mention of a body, and where it stands."""
    lists: list[tuple[KeyPath, tuple[PointGoal | DirectionGoal | KeepOut, ...]]] = []
    for path, goal in scenario.goal_tables.items():
        lists += [((*path, "point"), goal.point), ((*path, "direction"), goal.direction)]
    lists.append((("keep_out",), scenario.keep_out))
    named = [
        ((*path, k, "body"), entry.body) for path, rows in lists for k, entry in enumerate(rows)
    ]
    paths = scenario.objective.length if scenario.objective else ()
    return [*named, *((("objective", "length", name), name) for name in paths)]
