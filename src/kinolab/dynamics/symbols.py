"""The symbols of a machine: coordinates, their rates, and parameters.

They are SymPy symbols, so that a user calculates with them as on paper, and they carry what a
planner must know: topology, unit, limits and scale.
"""

from __future__ import annotations

import itertools
import math
from typing import Any, Literal, TypeAlias

import sympy

from kinolab.errors import InputError, Mistake

Topology: TypeAlias = Literal["line", "circle"]

_serial = itertools.count()


class Coordinate(sympy.Symbol):  # type: ignore[misc]
    """A generalised coordinate; two calls of ``length`` or ``angle`` never give the same one.

    Attributes:
        topology: ``line``, or ``circle`` for an angle without limits (it wraps at +-pi).
        unit: Unit of the coordinate, ``m`` or ``rad``.
        lower: Lower limit in that unit, -inf where there is none.
        upper: Upper limit in that unit, inf where there is none.
        speed: Largest magnitude of the rate in unit/s, inf where there is none.
        scale: What counts as a large difference, in that unit; distances are divided by it.
    """

    __slots__ = ("lower", "scale", "serial", "speed", "topology", "unit", "upper")

    topology: Topology
    unit: str
    lower: float
    upper: float
    speed: float
    scale: float
    serial: int

    def __new__(
        cls,
        name: str,
        topology: Topology,
        unit: str,
        limits: tuple[float, float],
        speed: float,
        scale: float,
        serial: int | None = None,
    ) -> Coordinate:
        _check_coordinate(name, limits, speed, scale)
        self: Coordinate = sympy.Symbol.__xnew__(cls, name, real=True)
        self.topology, self.unit = topology, unit
        self.lower, self.upper = limits
        self.speed, self.scale = speed, scale
        self.serial = next(_serial) if serial is None else serial
        return self

    def _hashable_content(self) -> tuple[Any, ...]:
        return (*super()._hashable_content(), self.serial)

    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        limits = (self.lower, self.upper)
        facts = (self.name, self.topology, self.unit, limits, self.speed, self.scale, self.serial)
        return facts, {}

    def __getstate__(self) -> None:
        return None


class Rate(sympy.Symbol):  # type: ignore[misc]
    """The time derivative of a coordinate, named after it: ``psi_dot`` for ``psi``."""

    __slots__ = ("coordinate",)

    coordinate: Coordinate

    def __new__(cls, coordinate: Coordinate) -> Rate:
        self: Rate = sympy.Symbol.__xnew__(cls, f"{coordinate.name}_dot", real=True)
        self.coordinate = coordinate
        return self

    def _hashable_content(self) -> tuple[Any, ...]:
        return (*super()._hashable_content(), self.coordinate.serial)

    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        return (self.coordinate,), {}

    def __getstate__(self) -> None:
        return None

    def _latex(self, printer: Any) -> str:
        return rf"\dot{{{printer._print(sympy.Symbol(self.coordinate.name))}}}"

    def _pretty(self, printer: Any) -> Any:
        return printer._print(_dotted(self.coordinate.name, "dot"))


class Acceleration(sympy.Symbol):  # type: ignore[misc]
    """The second time derivative of a coordinate, ``psi_ddot``; it occurs in equations only."""

    __slots__ = ("coordinate",)

    coordinate: Coordinate

    def __new__(cls, coordinate: Coordinate) -> Acceleration:
        self: Acceleration = sympy.Symbol.__xnew__(cls, f"{coordinate.name}_ddot", real=True)
        self.coordinate = coordinate
        return self

    def _hashable_content(self) -> tuple[Any, ...]:
        return (*super()._hashable_content(), self.coordinate.serial)

    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        return (self.coordinate,), {}

    def __getstate__(self) -> None:
        return None

    def _latex(self, printer: Any) -> str:
        return rf"\ddot{{{printer._print(sympy.Symbol(self.coordinate.name))}}}"

    def _pretty(self, printer: Any) -> Any:
        return printer._print(_dotted(self.coordinate.name, "ddot"))


class Parameter(sympy.Symbol):  # type: ignore[misc]
    """A constant of the machine with a default; a new value never recompiles anything.

    Attributes:
        default: Value in ``unit``.
        unit: SI unit as text, empty for a pure number.
    """

    __slots__ = ("default", "unit")

    default: float
    unit: str

    def __new__(cls, name: str, default: float, unit: str = "") -> Parameter:
        _check_name("parameter", name)
        if not math.isfinite(default):
            raise InputError([Mistake(f"parameter {name!r}", f"its value is {default}.")])
        self: Parameter = sympy.Symbol.__xnew__(cls, name, real=True)
        self.default, self.unit = float(default), unit
        return self

    def _hashable_content(self) -> tuple[Any, ...]:
        return (*super()._hashable_content(), self.default, self.unit)

    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        return (self.name, self.default, self.unit), {}

    def __getstate__(self) -> None:
        return None


class InputSymbol(sympy.Symbol):  # type: ignore[misc]
    """The value of an input of the machine, in the input's unit."""

    __slots__ = ()

    def __new__(cls, name: str) -> InputSymbol:
        self: InputSymbol = sympy.Symbol.__xnew__(cls, name, real=True)
        return self

    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        return (self.name,), {}

    def __getstate__(self) -> None:
        return None

    def _latex(self, printer: Any) -> str:
        symbol = printer._print(sympy.Symbol(self.name))
        return symbol if len(self.name) == 1 or symbol != self.name else rf"\mathrm{{{self.name}}}"


def length(
    name: str,
    lower: float = -math.inf,
    upper: float = math.inf,
    *,
    speed: float = math.inf,
    scale: float = 1.0,
) -> Coordinate:
    """Declare a coordinate on the line, in [m].

    Args:
        name: What scenarios, files and equations call it.
        lower: Lower limit in [m].
        upper: Upper limit in [m].
        speed: Largest magnitude of its rate in [m/s].
        scale: What counts as a large difference, in [m]; distances are divided by it.
    """
    return Coordinate(name, "line", "m", (float(lower), float(upper)), float(speed), float(scale))


def angle(
    name: str,
    lower: float = -math.inf,
    upper: float = math.inf,
    *,
    speed: float = math.inf,
    scale: float = 1.0,
) -> Coordinate:
    """Declare an angle in [rad]: on the circle, or on the line where it has limits.

    Args:
        name: What scenarios, files and equations call it.
        lower: Lower limit in [rad]; an angle with a limit does not wrap.
        upper: Upper limit in [rad].
        speed: Largest magnitude of its rate in [rad/s].
        scale: What counts as a large difference, in [rad]; distances are divided by it.
    """
    limits = (float(lower), float(upper))
    topology: Topology = "circle" if all(map(math.isinf, limits)) else "line"
    return Coordinate(name, topology, "rad", limits, float(speed), float(scale))


def parameter(name: str, default: float, unit: str = "") -> Parameter:
    """Declare a constant of the machine, such as a mass, with its default value and unit."""
    return Parameter(name, default, unit)


def rate(coordinate: Coordinate) -> Rate:
    """Return the symbol of the coordinate's time derivative."""
    return Rate(coordinate)


def _check_name(kind: str, name: str) -> None:
    if not name.isidentifier():
        remedy = "Use letters, digits and underscores, beginning with a letter."
        raise InputError([Mistake(f"{kind} {name!r}", "this is not a usable name.", remedy)])


def _check_coordinate(name: str, limits: tuple[float, float], speed: float, scale: float) -> None:
    _check_name("coordinate", name)
    where = f"coordinate {name!r}"
    mistakes = []
    if not limits[0] < limits[1]:
        what = f"its limits are {limits[0]:g} to {limits[1]:g}."
        mistakes.append(Mistake(where, what, "The lower limit must be below the upper one."))
    if not speed > 0:
        mistakes.append(Mistake(where, f"its speed limit is {speed:g}.", "It must be positive."))
    if not 0 < scale < math.inf:
        mistakes.append(Mistake(where, f"its scale is {scale:g}.", "It must be positive."))
    if mistakes:
        raise InputError(mistakes)


def _dotted(name: str, dots: str) -> sympy.Symbol:
    """Name a derivative so that SymPy's pretty printer puts dots over the letter."""
    letter, _, index = name.partition("_")
    return sympy.Symbol(f"{letter}{dots}" + (f"_{index}" if index else ""))
