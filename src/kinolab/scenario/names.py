"""Names in a scenario against the names that its machine has."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from kinolab.errors import Mistake
from kinolab.scenario.issues import Issue, KeyPath
from kinolab.scenario.locations import keys_of, mistake_at
from kinolab.scenario.rules import unknown_key
from kinolab.scenario.schema import DirectionGoal, GoalSection, KeepOut, PointGoal, Scenario


def check_names(
    scenario: Scenario,
    coordinates: Sequence[str],
    rates: Sequence[str],
    parameters: Sequence[str],
    bodies: Sequence[str],
    inputs: Sequence[str] = (),
) -> list[Mistake]:
    """List every name that the machine does not have, with the nearest that it has."""
    state = [*coordinates, *rates]
    goal = scenario.goal
    tolerances = goal.tolerance if isinstance(goal.tolerance, dict) else {}
    issues = [
        *_unknown(("system", "parameters"), scenario.system.parameters, parameters, "parameter"),
        *_unknown(("bounds",), scenario.bounds, [*state, *inputs], "coordinate, rate or input"),
        *_unknown(("metric",), scenario.metric, state),
        *_unknown(("start",), scenario.start, state),
        *_unknown(("goal",), goal.values, [*state, *keys_of(GoalSection)]),
        *_unknown(("goal", "tolerance"), tolerances, state),
        *(unknown_key(path, b, bodies, "body") for path, b in _bodies(scenario) if b not in bodies),
    ]
    return [mistake_at(issue, scenario.origin) for issue in issues]


def _unknown(
    path: KeyPath, names: Iterable[str], known: Sequence[str], kind: str = "coordinate or rate"
) -> list[Issue]:
    return [unknown_key((*path, name), name, known, kind) for name in names if name not in known]


def _bodies(scenario: Scenario) -> list[tuple[KeyPath, str]]:
    """Every mention of a body, and where it stands."""
    lists: list[tuple[KeyPath, tuple[PointGoal | DirectionGoal | KeepOut, ...]]] = [
        (("goal", "point"), scenario.goal.point),
        (("goal", "direction"), scenario.goal.direction),
        (("keep_out",), scenario.keep_out),
    ]
    return [
        ((*path, k, "body"), entry.body) for path, rows in lists for k, entry in enumerate(rows)
    ]
