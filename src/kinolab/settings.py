"""Planner settings: declared once as dataclass fields, read by everything that names them.

Scenarios check values against it, ``plan list planners`` and the documentation print it.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

KINDS: Mapping[type, str] = {
    bool: "truth value",
    int: "whole number",
    float: "number",
    str: "text",
    tuple: "list",
    dict: "table",
}


@dataclass(frozen=True)
class Setting:
    """One planner setting.

    Attributes:
        name: Its key below [planner] in a scenario.
        default: Default value.
        lowest: Smallest allowed value, None for no limit.
        highest: Largest allowed value, None for no limit.
        above: Strict lower bound, None for no limit.
        unit: Such as "m"; empty if dimensionless or no number.
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
        """The kind of its values in words, to follow "a"."""
        return KINDS.get(type(self.default), type(self.default).__name__)

    @property
    def range(self) -> str:
        """The allowed values in words; empty where every value of its kind is allowed."""
        if isinstance(self.default, bool):
            return "true or false"
        if self.lowest is not None and self.highest is not None:
            return f"{_plain(self.lowest)} to {_plain(self.highest)}"
        return ", ".join(f"{words} {_plain(end)}" for words, end, _ in self._ends())

    def misfit(self, value: Any) -> tuple[str, str] | None:
        """Return what is wrong with a value and what would work; None if it is valid."""
        if not self.accepts(value):
            remedy = f"Give a {self.kind}, such as the default {self.default!r}."
            return f"{value!r} does not fit.", remedy
        if not all(fits(value, end) for _, end, fits in self._ends()):
            wanted = ", ".join(f"{words} {end}" for words, end, _ in self._ends())
            return f"{value!r} is out of range.", f"Give {wanted}."
        return None

    def accepts(self, value: Any) -> bool:
        """Whether a value is of its kind; an integer is accepted as a float."""
        if isinstance(self.default, bool) or isinstance(value, bool):
            return isinstance(value, bool) and isinstance(self.default, bool)
        if isinstance(self.default, float):
            return isinstance(value, int | float)
        return isinstance(value, type(self.default))

    def _ends(self) -> list[tuple[str, float, Callable[[Any, Any], bool]]]:
        """Return the finite limits, each with the words before it, and what keeps it."""
        ends = (
            ("more than", self.above, operator.gt),
            ("at least", self.lowest, operator.ge),
            ("at most", self.highest, operator.le),
        )
        return [(words, end, fits) for words, end, fits in ends if end is not None]


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
        default: Default value; its type is the type of all values.
        lowest: Smallest allowed value.
        highest: Largest allowed value.
        above: Strict lower bound, instead of ``lowest``.
        unit: Such as "m"; left out if dimensionless.
        meaning: A sentence for ``plan list planners``.
    """
    told = Setting("", default, lowest, highest, above, unit, meaning)
    return field(default=default, metadata={"setting": told})


def with_default(default: Any, planner: type, name: str) -> Any:
    """Declare another planner's setting with a different default.

    Args:
        default: Default value.
        planner: The planner that declares it.
    """
    told = {entry.name: entry.metadata for entry in fields(planner)}
    return field(default=default, metadata=told[name])


def settings_of(planner: type) -> tuple[Setting, ...]:
    """Return a planner's settings: the fields of its dataclass, inherited ones first.

    A field declared without ``setting`` has a name and a default, but no limits; one declared
    without a default, which is no setting, has ``dataclasses.MISSING``.
    """
    found = []
    for entry in fields(planner):
        default: Any = entry.default
        if entry.type in (float, "float") and type(default) is int:
            default = float(default)  # "x: float = 5" takes 5.5 too
        declared = entry.metadata.get("setting", Setting("", None))
        found.append(replace(declared, name=entry.name, default=default))
    return tuple(found)


def _plain(number: float) -> str:
    """Print a limit in plain notation: 1000000 and 0.05, neither 1e+06 nor 1000000.0."""
    return str(number) if isinstance(number, int) else f"{number:.15g}"
