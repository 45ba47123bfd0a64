"""What can be done to a scenario, as changes of its text: pure functions of what it says.

Lengths in [m], angles in [rad]. Obstacles are named by their place in the list.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from typing import Any

from kinolab import systems
from kinolab.scenario.rules import OBSTACLE_KINDS
from kinolab.scenario.schema import TOLERANCE
from kinolab.studio.core.scenario_text import Add, Change, Drop, Put

Values = Mapping[str, Any]
OBSTACLES = ("world", "obstacle")
WALL_THICKNESS = 0.1  # [m]
DIGITS = 4  # of what a mouse gives, after the point: a tenth of a millimetre
OF_MACHINE = ("bounds", "metric", "start", "goal", "via", "keep_out", "objective")
NEW_SIZES: Mapping[str, Any] = {
    "box": [0.5, 0.5, 0.5],
    "sphere": 0.25,
    "cylinder": [0.25, 0.5],
    "capsule": [0.15, 0.2],
}  # [m]


def empty(title: str, machine: str) -> str:
    """Return the text of a scenario of a machine in an empty world.

    Start and goal are left to be chosen where the machine has no place on the ground; lengths that
    nothing limits are limited.
    """
    text = files("kinolab.studio.core").joinpath("empty.toml").read_text("utf-8")
    coordinates = systems.get(machine).coordinates
    if not {"x", "y"} <= {coordinate.name for coordinate in coordinates}:
        text = text[: text.index("[start]")].rstrip() + "\n"
    unlimited = [c.name for c in coordinates if c.unit == "m" and math.isinf(c.upper - c.lower)]
    if far := [name for name in unlimited if name not in ("x", "y")]:
        # 5 [m] from the middle: as large as the ground
        lines = "".join(f"{name} = [-5.0, 5.0]\n" for name in far)
        text += f"\n[bounds]  # [m]\n{lines}"
    return text.replace("{title}", title).replace("{machine}", machine)


def obstacles(values: Values) -> list[dict[str, Any]]:
    """Return the obstacles as they are written."""
    return list(values.get("world", {}).get("obstacle", []))


def kind_of(obstacle: Values) -> str:
    """Return which shape an obstacle has; empty where it says none."""
    return next((kind for kind in OBSTACLE_KINDS if kind in obstacle), "")


def tidy(numbers: Iterable[float]) -> list[float]:
    """Return numbers as somebody would type them, without minus zero."""
    return [round(float(number), DIGITS) + 0.0 for number in numbers]


def fresh(values: Values, stem: str) -> str:
    """Return a name for an obstacle that is not taken."""
    taken = {each.get("name") for each in obstacles(values)}
    stem = stem.rstrip("0123456789 ") or stem
    count = 1
    while (name := f"{stem} {count}") in taken:
        count += 1
    return name


def add_obstacle(
    values: Values, kind: str, size: Any, position: Sequence[float], name: str = ""
) -> list[Change]:
    """Add an obstacle; ``size`` is what its shape's key takes, the path of a mesh."""
    called = fresh(values, name or ("ball" if kind == "sphere" else kind))
    entry = {"name": called, kind: size, "position": tidy(position)}
    return [Add(OBSTACLES, entry)]


def add_wall(
    values: Values, a: Sequence[float], b: Sequence[float], height: float, name: str = "wall"
) -> list[Change]:
    """Add a wall on the ground between two points (2,) of it."""
    length = math.dist(a[:2], b[:2])
    if length < WALL_THICKNESS:
        return []
    box = tidy([length + WALL_THICKNESS, WALL_THICKNESS, height])
    middle = tidy([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * height])
    entry = {"name": fresh(values, name), "box": box, "position": middle}
    turn = tidy([0.0, 0.0, math.atan2(b[1] - a[1], b[0] - a[0])])
    return [Add(OBSTACLES, {**entry, "rpy": turn} if any(turn) else entry)]


def add_room(
    values: Values, low: Sequence[float], high: Sequence[float], height: float
) -> list[Change]:
    """Add four walls around the rectangle between two corners (2,)."""
    (a, b), (c, d) = low, high
    corners = [(a, b), (c, b), (c, d), (a, d)]
    changes: list[Change] = []
    for k, corner in enumerate(corners):
        name = f"{('south', 'east', 'north', 'west')[k]} wall"
        changes += add_wall(values, corner, corners[(k + 1) % 4], height, name)
    return changes


def duplicate(values: Values, number: int, shift: float) -> list[Change]:
    """Add an obstacle like another one, beside it along x."""
    entry = obstacles(values)[number]
    x, y, z = entry.get("position", (0.0, 0.0, 0.0))
    name = fresh(values, entry.get("name") or kind_of(entry))
    return [Add(OBSTACLES, {**entry, "name": name, "position": tidy([x + shift, y, z])})]


def remove(values: Values, number: int) -> list[Change]:
    """Remove an obstacle."""
    last = len(obstacles(values)) == 1  # an empty list would be written into [world]
    return [Drop(OBSTACLES if last else (*OBSTACLES, number))]


def alter(values: Values, number: int, **keys: Any) -> list[Change]:
    """Write keys of an obstacle; what is None, or rpy = 0 where nothing stands, is left out."""
    entry, changes = obstacles(values)[number], list[Change]()
    for key, value in keys.items():
        place = (*OBSTACLES, number, key)
        if value is None:
            changes.append(Drop(place))
        elif entry.get(key) != value and (key in entry or key != "rpy" or any(value)):
            changes.append(Put(place, value))
    return changes


def set_state(section: str, state: Mapping[str, Any]) -> list[Change]:
    """Write entries of [start] or [goal]."""
    return [Put((section, name), value) for name, value in state.items()]


def ask(values: Values, name: str, value: Any, tolerance: float | None) -> list[Change]:
    """Have the goal ask for an entry, within a tolerance; without a tolerance, leave it free."""
    goal = values.get("goal", {})
    own = goal.get("tolerance", TOLERANCE)
    if tolerance is None:
        dropped: list[Change] = [Drop(("goal", name))]
        return dropped + ([Drop(("goal", "tolerance", name))] if isinstance(own, dict) else [])
    changes: list[Change] = [] if goal.get(name) == value else [Put(("goal", name), value)]
    now = own.get(name, TOLERANCE) if isinstance(own, dict) else own
    if now == tolerance:
        return changes
    if isinstance(own, dict):
        return [*changes, Put(("goal", "tolerance", name), tolerance)]
    others = [key for key in goal_entries(goal) if key != name]
    if not others:
        return [*changes, Put(("goal", "tolerance"), tolerance)]
    table = {**dict.fromkeys(others, own), name: tolerance}
    return [*changes, Put(("goal", "tolerance"), table)]


def goal_entries(goal: Values) -> list[str]:
    """Return the coordinates and rates that a [goal] asks for."""
    keys = ("tolerance", "norm", "at_rest", "hold", "order", "reserve", "point", "direction")
    return [key for key in goal if key not in keys]


def choose_machine(values: Values, name: str) -> list[Change]:
    """Take another machine; what is said of the former one's coordinates goes."""
    changes: list[Change] = [Put(("system", "name"), name)]
    changes += [Drop(("system", key)) for key in values.get("system", {}) if key != "name"]
    return changes + [Drop((key,)) for key in OF_MACHINE if key in values]


def choose_planner(values: Values, name: str, shared: Sequence[str]) -> list[Change]:
    """Take another planner; settings of the former one go, all planners' stay."""
    kept = {*shared, "name"}
    former = [key for key in values.get("planner", {}) if key not in kept]
    return [*(Drop(("planner", key)) for key in former), Put(("planner", "name"), name)]


def choose_objective(weights: Mapping[str, float]) -> list[Change]:
    """Write what a motion costs; without weights the duration."""
    told = {key: weight for key, weight in weights.items() if weight}
    only_time = not told or list(told) == ["time"]
    return [Drop(("objective",))] if only_time else [Put(("objective",), told)]
