"""Names in a scenario against the names that its machine has."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from kinolab.errors import Mistake
from kinolab.scenario.issues import Issue, KeyPath
from kinolab.scenario.locations import keys_of, mistake_at
from kinolab.scenario.rules import unknown_key
from kinolab.scenario.schema import GoalSection, Scenario


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
        *(issue for path, body in _bodies(scenario) for issue in _body(path, body, bodies)),
    ]
    return [mistake_at(issue, scenario.origin) for issue in issues]


def _unknown(
    path: KeyPath, names: Iterable[str], known: Sequence[str], kind: str = "coordinate or rate"
) -> list[Issue]:
    return [unknown_key((*path, name), name, known, kind) for name in names if name not in known]


def _bodies(scenario: Scenario) -> list[tuple[KeyPath, str]]:
    """Every mention of a body, and where it stands."""
    points, directions = scenario.goal.point, scenario.goal.direction
    return [
        *((("goal", "point", place, "body"), entry.body) for place, entry in enumerate(points)),
        *(
            (("goal", "direction", place, "body"), entry.body)
            for place, entry in enumerate(directions)
        ),
        *((("keep_out", place, "body"), cone.body) for place, cone in enumerate(scenario.keep_out)),
    ]


def _body(path: KeyPath, body: str, bodies: Sequence[str]) -> list[Issue]:
    return [] if body in bodies else [unknown_key(path, body, bodies, "body")]
