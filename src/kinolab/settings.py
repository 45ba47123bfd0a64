"""What a setting of a planner is: declared once, and read from there by everything that names it.

Scenarios check values against it, ``plan list planners`` and the documentation print it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import Field, dataclass, field, fields
from typing import Any

KINDS: Mapping[type, str] = {
    bool: "truth value",
    int: "whole number",
    float: "number",
    str: "text",
    tuple: "list",
    dict: "table",
}

OLD_NAMES: Mapping[str, str] = {  # what settings were called until 2026
    "berth": "clearance_cost_radius",
    "draws": "control_samples",
    "escapes": "random_walk_escapes",
    "goal_zoom": "goal_region_scale",
    "greed": "cost_to_go_exponent",
    "influence": "influence_distance",
    "inputs_tried": "control_samples",
    "last_step_every": "goal_connection_period",
    "memory": "grid_memory",
    "most_in_cell": "max_states_per_cell",
    "near": "goal_connection_distance",
    "patience": "stall_time",
    "pull": "attractive_gain",
    "repulsion": "repulsive_gain",
}


@dataclass(frozen=True)
class Setting:
    """One setting.

    Attributes:
        name: What a scenario writes below [planner].
        default: Its value where a scenario says nothing.
        lowest: The smallest value, None for no limit.
        highest: The largest value, None for no limit.
        above: What the value must exceed, None for no limit.
        unit: Such as "m"; empty for pure numbers and for what is no number.
        meaning: A sentence.
    """

    name: str
    default: Any
    lowest: float | None = None
    highest: float | None = None
    above: float | None = None
    unit: str = ""
    meaning: str = ""

    @property
    def kind(self) -> str:
        """What its values are, to follow "a"."""
        return KINDS.get(type(self.default), type(self.default).__name__)

    @property
    def range(self) -> str:
        """Which values it takes, in words; empty where every value of its kind will do."""
        if isinstance(self.default, bool):
            return "true or false"
        if self.lowest is not None and self.highest is not None:
            return f"{_plain(self.lowest)} to {_plain(self.highest)}"
        return ", ".join(f"{words} {_plain(end)}" for words, end in self._ends())

    def misfit(self, value: Any) -> tuple[str, str] | None:
        """Return what is wrong with a value and what would work, or None where it will do."""
        if not self.accepts(value):
            remedy = f"Give a {self.kind}, such as the default {self.default!r}."
            return f"{value!r} does not fit.", remedy
        if not self._reaches(value):
            wanted = ", ".join(f"{words} {end}" for words, end in self._ends())
            return f"{value!r} is out of range.", f"Give {wanted}."
        return None

    def accepts(self, value: Any) -> bool:
        """Whether a value is of its kind; a whole number may stand where a number is meant."""
        if isinstance(self.default, bool) or isinstance(value, bool):
            return isinstance(value, bool) and isinstance(self.default, bool)
        if isinstance(self.default, float):
            return isinstance(value, int | float)
        return isinstance(value, type(self.default))

    def _ends(self) -> list[tuple[str, float]]:
        """Return the limits that there are, each with the words in front of it."""
        ends = (("more than", self.above), ("at least", self.lowest), ("at most", self.highest))
        return [(words, end) for words, end in ends if end is not None]

    def _reaches(self, value: Any) -> bool:
        return (
            (self.above is None or value > self.above)
            and (self.lowest is None or value >= self.lowest)
            and (self.highest is None or value <= self.highest)
        )


def setting(
    default: Any,
    lowest: float | None = None,
    highest: float | None = None,
    *,
    above: float | None = None,
    unit: str = "",
    meaning: str = "",
) -> Any:
    """Declare a setting of a planner, as the default of a field of its dataclass.

    Args:
        default: Its value where a scenario says nothing; its type is the type of all values.
        lowest: The smallest value.
        highest: The largest value.
        above: What the value must exceed, where no smallest value will do.
        unit: Such as "m"; left out for pure numbers.
        meaning: A sentence for ``plan list planners``.
    """
    told = {"lowest": lowest, "highest": highest, "above": above, "unit": unit, "meaning": meaning}
    return field(default=default, metadata=told)


def with_default(default: Any, planner: type, name: str) -> Any:
    """Declare a setting as another planner has it, but for its default.

    Args:
        default: Its value where a scenario says nothing.
        planner: Whose setting it is.
        name: Of the setting.
    """
    told = {entry.name: entry.metadata for entry in fields(planner)}
    return field(default=default, metadata=told[name])


def settings_of(planner: type) -> tuple[Setting, ...]:
    """Return the settings of a planner: the fields of its dataclass, inherited ones first.

    One that was declared without ``setting`` has a name and a default, and no limits; one that was
    declared without a default, which is no planner's setting, has ``dataclasses.MISSING`` for it.
    """
    return tuple(_read(entry) for entry in fields(planner))


def _read(entry: Field[Any]) -> Setting:
    known = ("lowest", "highest", "above", "unit", "meaning")
    told = {key: entry.metadata[key] for key in known if key in entry.metadata}
    default: Any = entry.default
    if entry.type in (float, "float") and type(default) is int:
        default = float(default)  # "x: float = 5" takes 5.5 too
    return Setting(entry.name, default, **told)


def _plain(number: float) -> str:
    """Write a limit as people do: 1000000 and 0.05, neither 1e+06 nor 1000000.0."""
    return str(number) if isinstance(number, int) else f"{number:.15g}"
