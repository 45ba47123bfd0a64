"""An environment of the benchmark as a scenario, with all mistakes of the file at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from kinolab.errors import Mistake, unknown_name
from kinolab.scenario.dynobench.machines import MACHINES, ROTATION, KnownMachine
from kinolab.scenario.dynobench.yaml_tree import Entry, Found, yaml_tree
from kinolab.scenario.file_lookup import read_text
from kinolab.scenario.load import check_document
from kinolab.scenario.schema import Scenario

GOAL_TOLERANCE = 0.0299  # of the benchmark's distance, which it wants below 0.03


def is_environment(source: str | Path) -> bool:
    """Whether a path is one of an environment, by its ending."""
    return Path(source).suffix.lower() in (".yaml", ".yml")


def read_environment(
    source: str | Path, *, overrides: Sequence[str] = ()
) -> tuple[Scenario | None, list[Mistake]]:
    """Read an environment as a scenario, and list its mistakes instead of raising them.

    The goal region is that of the benchmark or a little smaller: the sum of all weighted deviations
    counts, where the benchmark takes the Euclidean norm of some of them first. The workspace limits
    the coordinates x, y and z, not the places of all bodies.

    Args:
        overrides: ``KEY=VALUE`` texts that replace keys of the scenario.

    Returns:
        The scenario, or None where the file has mistakes; and the mistakes.

    Raises:
        InputError: If there is no such file or it is not YAML.
    """
    path = Path(source)
    found: Found = []
    tree = yaml_tree(read_text(path), path.name, found)
    document = _EnvironmentReader(path.name, found).document(tree)
    if found:
        return None, [mistake for _, mistake in sorted(found, key=lambda pair: pair[0])]
    return check_document(document, path, overrides=overrides)


class _EnvironmentReader:
    """Checks one file; what is wrong is added to a list, and the rest is read on.

    Args:
        label: What mistakes call the file.
        mistakes: Where to add to.
    """

    def __init__(self, label: str, mistakes: Found) -> None:
        self._label, self._mistakes = label, mistakes

    def document(self, tree: Entry) -> dict[str, Any]:
        """Return the scenario's keys; they are whole where no mistake was found."""
        top = self._table(tree, ("environment", "robots"), ("name",))
        robot = self._robot(top.get("robots"))
        machine = self._machine(robot.get("type"))
        world = self._world(top.get("environment"), machine)
        kept: dict[str, Any] = {}  # the keys that are the same in all environments of a machine
        if machine is not None:
            kept = {
                "system": {"name": str(robot["type"].value)},
                "metric": dict(machine.weights),
                "integration": {"method": "euler", "step": machine.step, "truth": "discrete"},
                "render": {"view": machine.view},
            }
        return {
            "schema": 1,
            "title": f"{self._name(top.get('name'))[:80]} (dynobench)",
            **world,
            **self._ends(robot, machine),
            **kept,
        }

    def _name(self, name: Entry | None) -> str:
        if name is not None and isinstance(name.value, dict | list):
            self._wrong(name, "this is no text.", "Give a name, or leave it out.")
        given = "" if name is None or name.value is None else str(name.value)
        return given or Path(self._label).stem

    def _robot(self, robots: Entry | None) -> dict[str, Entry]:
        if robots is None:
            return {}
        if not isinstance(robots.value, list) or not robots.value:
            self._wrong(robots, "this is no list of robots.", "Give one: - type, start and goal.")
            return {}
        if len(robots.value) > 1:
            what = f"there are {len(robots.value)} robots."
            self._wrong(robots, what, "kinolab plans for one.")
        first, *_ = robots.value
        return self._table(first, ("type", "start", "goal"))

    def _machine(self, kind: Entry | None) -> KnownMachine | None:
        if kind is None:
            return None
        if isinstance(kind.value, str) and kind.value in MACHINES:
            return MACHINES[kind.value]
        name = kind.value if isinstance(kind.value, str) else "this"
        self._unknown(kind, "robot type", name, sorted(MACHINES))
        return None

    def _world(self, world: Entry | None, machine: KnownMachine | None) -> dict[str, Any]:
        """Return limits of the reference point, and what stands in its way."""
        if world is None:
            return {}
        table = self._table(world, ("min", "max"), ("obstacles",))
        least = table["min"].value if "min" in table else None
        known = isinstance(least, list) and len(least) == 3  # of a machine that is not
        size = machine.dimension if machine else 3 if known else 2
        axes = "xyz"[:size]
        ends = [self._numbers(table.get(key), axes) for key in ("min", "max")]
        for i, (lower, upper) in enumerate(zip(*ends, strict=False)):
            if not lower < upper:
                what = f"min of {axes[i]} is {lower:g} and max {upper:g}."
                self._wrong(table["max"], what, "Put min below max.")
        limited = [axis for axis in axes if machine and axis in machine.weights]
        limits = {axis: pair for axis, *pair in zip(axes, *ends, strict=False) if axis in limited}
        return {
            "bounds": limits,
            "world": {"obstacle": self._obstacles(table.get("obstacles"), axes)},
        }

    def _obstacles(self, obstacles: Entry | None, axes: str) -> list[dict[str, Any]]:
        if obstacles is None or obstacles.value is None:
            return []
        if not isinstance(obstacles.value, list):
            self._wrong(obstacles, "this is no list.", "Give - type, center and size, or [].")
            return []
        return [self._obstacle(entry, axes) for entry in obstacles.value]

    def _obstacle(self, entry: Entry, axes: str) -> dict[str, Any]:
        table = self._table(entry, ("type", "center", "size"))
        centre = self._numbers(table.get("center"), axes)
        kind = table.get("type")
        if kind is not None and kind.value not in ("box", "sphere"):
            self._unknown(kind, "obstacle type", str(kind.value), ("box", "sphere"))
        if kind is None or kind.value not in ("box", "sphere"):
            return {}
        named = [f"size along {axis}" for axis in axes] if kind.value == "box" else ["radius"]
        size = self._numbers(table.get("size"), named)
        if size and not min(size) > 0:
            self._wrong(table["size"], f"{min(size):g} m is no size.", "Give positive numbers.")
        flat = len(axes) == 2
        shape: dict[str, Any] = {"sphere": size[0]} if kind.value == "sphere" and size else {}
        if kind.value == "box":
            # [m] height of obstacles in the plane, about z = 0
            shape = {"box": [*size, 1.0] if flat else size}
        return {**shape, "position": [*centre, 0.0] if flat else centre}

    def _ends(self, robot: dict[str, Entry], machine: KnownMachine | None) -> dict[str, Any]:
        """Return start and goal by the names of coordinates and rates."""
        found: dict[str, Any] = {}
        for key in ("start", "goal"):
            if machine is None:
                self._numbers(robot.get(key))
                continue
            numbers = self._numbers(robot.get(key), machine.numbers)
            found[key] = _named(machine, numbers) if numbers else {}
            if ROTATION in found[key] and not any(found[key][ROTATION]):
                self._wrong(robot[key], "its quaternion is zero.", "[0, 0, 0, 1] is not turned.")
        if machine is not None and "goal" in found:
            whole = {ROTATION: 2.0}  # goals measure a turn's whole angle, the benchmark half of it
            tolerance = {
                name: whole.get(name, 1.0) * GOAL_TOLERANCE / weight
                for name, weight in machine.weights.items()
            }
            found["goal"] |= {"tolerance": tolerance, "norm": "sum"}  # what deviations add up to
        return found

    def _table(
        self, entry: Entry, required: Sequence[str], optional: Sequence[str] = ()
    ) -> dict[str, Entry]:
        """Return the entries of a table; name those that are missing and those nobody knows."""
        known = (*required, *optional)
        if not isinstance(entry.value, dict):
            self._wrong(entry, "this is no table.", f"Give {', '.join(known)}.")
            return {}
        for key, value in entry.value.items():
            if key not in known:
                self._unknown(value, "key", key, known)
        for key in required:
            if key not in entry.value:
                self._wrong(entry, f"{key} is missing.", f"Give {', '.join(required)}.")
        return {key: value for key, value in entry.value.items() if key in known}

    def _numbers(self, entry: Entry | None, names: Sequence[str] | None = None) -> list[float]:
        """Return a list of finite numbers, one for each name; empty where it is none."""
        if entry is None:
            return []
        wanted = "finite numbers" if names is None else ", ".join(names)
        if not isinstance(entry.value, list):
            self._wrong(entry, "this is no list.", f"Give [{wanted}].")
            return []
        bad = [
            item
            for item in entry.value
            if isinstance(item.value, bool)
            or not (isinstance(item.value, int | float) and math.isfinite(item.value))
        ]
        for item in bad:
            shown = f"{item.value!r}"[:60] if not isinstance(item.value, dict | list) else "this"
            self._wrong(item, f"{shown} is no finite number.")
        if names is not None and len(entry.value) != len(names):
            what = f"its length is {len(entry.value)}, not {len(names)}."
            self._wrong(entry, what, f"Give [{wanted}].")
        elif not bad:
            return [float(item.value) for item in entry.value]  # type: ignore[arg-type]
        return []

    def _unknown(self, entry: Entry, kind: str, name: str, known: Sequence[str]) -> None:
        unknown = unknown_name(kind, name[:60], known=known)
        self._wrong(entry, unknown.what, unknown.remedy)

    def _wrong(self, entry: Entry, what: str, remedy: str = "") -> None:
        where = f"{self._label} line {entry.line} {entry.path}".rstrip()
        self._mistakes.append((entry.line, Mistake(where, what, remedy)))


def _named(machine: KnownMachine, numbers: Sequence[float]) -> dict[str, Any]:
    """Return the numbers of a state by the names of coordinates and rates."""
    rest = list(numbers)
    return {
        name: [rest.pop(0) for _ in range(4)] if name == ROTATION else rest.pop(0)
        for name in machine.weights
    }
