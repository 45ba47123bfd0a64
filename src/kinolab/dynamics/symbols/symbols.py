"""The symbols of a machine: coordinates, rates, inputs, auxiliary states and parameters.

SymPy symbols, for symbolic expressions, with the attributes that planners need: topology, unit,
limits and scale.
"""

from __future__ import annotations

import inspect
import itertools
import math
from dataclasses import dataclass
from typing import Any, Literal, Self, TypeAlias

import sympy
from sympy.printing.pretty.pretty_symbology import pretty_symbol
from sympy.printing.pretty.stringpict import prettyForm

from kinolab.arguments import checked
from kinolab.dynamics.symbols import slips
from kinolab.errors import InputError, Mistake
from kinolab.numerics.manifolds.state_parts import Circle, Directions, Part, RealLine, Rotations

Topology: TypeAlias = Literal["line", "circle", "sphere"]

_serial = itertools.count()


class MachineSymbol(sympy.Symbol):  # type: ignore[misc]
    """A symbol with attributes; equal name and attributes mean equality, also after pickling.

    Attributes:
        facts: What tells it from others of its name; those that a subclass annotates are its first.
    """

    facts: tuple[Any, ...]

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        for place, name in enumerate(inspect.get_annotations(cls)):
            setattr(cls, name, property(lambda own, k=place: own.facts[k]))  # type: ignore[misc]

    @classmethod
    def _build(cls, name: str, facts: tuple[Any, ...]) -> Self:
        self: Self = sympy.Symbol.__xnew__(cls, name, real=True)
        self.facts = facts
        return self

    def _hashable_content(self) -> tuple[Any, ...]:
        return (*super()._hashable_content(), *self.facts)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self)._build, (self.name, self.facts)

    def __reduce_ex__(self, protocol: Any) -> tuple[Any, ...]:
        return self.__reduce__()

    def __getattr__(self, name: str) -> Any:
        return slips.attribute(self, name)

    __float__ = __int__ = __round__ = slips.no_number

    def diff(self, *symbols: Any, **assumptions: Any) -> sympy.Expr:
        """Differentiate by symbols of the machine; by time ``rate`` does.

        Raises:
            SlipError: If by something else, by which SymPy's derivative would be 0.
        """
        if not symbols or not all(map(_may_vary, symbols)):
            call = f"{self}.diff({', '.join(map(repr, symbols))})"
            slips.slipped(call, "time is no symbol of a machine.", slips.written(self))
        return super().diff(*symbols, **assumptions)


def _may_vary(symbol: Any) -> bool:
    """Whether a symbol is not time under one of its usual names, nor a text."""
    plain = isinstance(symbol, sympy.Symbol) and not isinstance(symbol, MachineSymbol)
    return not isinstance(symbol, str) and not (plain and symbol.name in ("t", "time"))


@checked
class Coordinate(MachineSymbol):
    """A generalised coordinate; every call of ``length`` or ``angle`` returns a distinct one.

    Attributes:
        serial: Creation order of coordinates.
        topology: ``circle`` for an angle without limits, ``sphere`` for a direction, or ``line``.
        unit: Unit of the coordinate, ``m`` or ``rad``.
        lower: Lower limit in that unit, -inf where there is none.
        upper: Upper limit in that unit, inf where there is none.
        speed: Largest magnitude of the rate in unit/s, inf where there is none.
        scale: Characteristic magnitude in that unit; distances are divided by it.
    """

    serial: int
    topology: Topology
    unit: str
    lower: float
    upper: float
    speed: float
    scale: float

    def __new__(
        cls,
        name: str,
        topology: Topology,
        unit: str,
        limits: tuple[float, float],
        speed: float,
        scale: float,
    ) -> Coordinate:
        """Validate and store a coordinate's attributes; users call ``length`` or ``angle``."""
        _check_coordinate(name, limits, speed, scale)
        return cls._build(name, (next(_serial), topology, unit, *limits, speed, scale))

    @property
    def entries(self) -> tuple[Coordinate]:
        """The symbols of its entries in a state."""
        return (self,)

    @property
    def rates(self) -> tuple[RateSymbol]:
        """The symbols of its velocities."""
        return (RateSymbol(self),)

    def part(self, first: int) -> Part:
        """Return its part of a state, in which it has the entry ``first``."""
        if self.topology == "sphere":
            return Directions(self.name.removesuffix("_x"), first, 3)
        return (Circle if self.topology == "circle" else RealLine)(self.name, first)


class AttitudeSymbol(MachineSymbol):
    """A component, of an index, of an attitude's quaternion or of its angular velocity."""

    attitude: Attitude
    index: int
    letter = ""  # before that of the component

    def __new__(cls, attitude: Attitude, index: int) -> Self:
        """Make a component; users call ``rotation`` and ``turn_rate``."""
        return cls._build(f"{attitude.name}_{cls.letter}{'xyzw'[index]}", (attitude, index))


class QuaternionEntry(AttitudeSymbol):
    """An entry of an attitude's unit quaternion: x, y, z of the vector part, then the scalar w."""


class TurnRate(AttitudeSymbol):
    """A component of an attitude's angular velocity, in body axes."""

    letter = "w"

    def _latex(self, _: Any) -> str:
        return rf"\omega_{{{self.attitude.name},{'xyz'[self.index]}}}"


class TurnAcceleration(MachineSymbol):
    """The derivative of an angular velocity component; it occurs in equations only."""

    turn: TurnRate

    def __new__(cls, turn: TurnRate) -> TurnAcceleration:
        """Make the derivative of a component."""
        return cls._build(f"{turn.name}_dot", (turn,))

    def _latex(self, printer: Any) -> str:
        return rf"\dot{{{printer._print(self.turn)}}}"


@checked
@dataclass(frozen=True, order=True)
class Attitude:
    """A coordinate on SO(3), free of singularities.

    Its state is a unit quaternion x, y, z, w and the angular velocity in body axes. Attitudes are
    ordered because SymPy sorts symbols by their attributes.

    Attributes:
        name: Its name in scenarios, files and equations.
        speed: Largest magnitude of each component of the angular velocity, in [rad/s].
        scale: Characteristic rotation angle in [rad].
        serial: Creation order of coordinates.
    """

    name: str
    speed: float
    scale: float
    serial: int

    unit = "rad"
    lower, upper = -1.0, 1.0  # of an entry of its quaternion

    @property
    def quaternion(
        self,
    ) -> tuple[QuaternionEntry, QuaternionEntry, QuaternionEntry, QuaternionEntry]:
        """The symbols of the quaternion's entries x, y, z, w."""
        x, y, z, w = (QuaternionEntry(self, index) for index in range(4))
        return x, y, z, w

    @property
    def turn_rate(self) -> tuple[TurnRate, TurnRate, TurnRate]:
        """The symbols of the angular velocity's components in body axes."""
        x, y, z = (TurnRate(self, index) for index in range(3))
        return x, y, z

    entries, rates = quaternion, turn_rate  # as every coordinate's

    def part(self, first: int) -> Rotations:
        """Return its part of a state, in which its quaternion begins at an entry."""
        return Rotations(self.name, first, 4)


class TimeDerivative(MachineSymbol):
    """A time derivative of a coordinate, named after it and printed with dots."""

    coordinate: Coordinate
    order = 0

    def __new__(cls, coordinate: Coordinate) -> Self:
        """Make the derivative of a coordinate."""
        return cls._build(f"{coordinate.name}_{'d' * cls.order}ot", (coordinate,))

    def _latex(self, printer: Any) -> str:
        letter = printer._print(sympy.Symbol(self.coordinate.name))
        return rf"\{'d' * self.order}ot{{{letter}}}"

    def _pretty(self, printer: Any) -> Any:
        # SymPy's pretty printer puts dots over what ends in dot or ddot: of a word over one letter.
        letter, _, index = self.coordinate.name.partition("_")
        if len(pretty_symbol(letter.rstrip("0123456789"))) > 1:
            return prettyForm(self.name)
        dotted = f"{letter}{'d' * self.order}ot" + (f"_{index}" if index else "")
        return printer._print(sympy.Symbol(dotted))


class RateSymbol(TimeDerivative):
    """The time derivative of a coordinate: ``psi_dot`` for ``psi``."""

    order = 1


class Acceleration(TimeDerivative):
    """The second time derivative of a coordinate, ``psi_ddot``; it occurs in equations only."""

    order = 2


@checked
class Parameter(MachineSymbol):
    """A constant of the machine with a default; changing its value needs no recompilation.

    Attributes:
        name: In scenarios, files and equations.
        default: Value in ``unit``.
        unit: SI unit as text, empty if dimensionless.
    """

    default: float
    unit: str

    def __new__(cls, name: str, default: float, unit: str = "") -> Parameter:
        """Validate and store a parameter's attributes."""
        _check_name("parameter", name)
        if not math.isfinite(default):
            raise InputError([Mistake(f"parameter {name!r}", f"its value is {default}.")])
        return cls._build(name, (float(default), unit))


class NamedSymbol(MachineSymbol):
    """A symbol that its name alone determines."""

    bearer = ""  # what users give the name to, where it becomes one here

    def __new__(cls, name: str) -> Self:
        """Make the symbol; users declare what it is the value of."""
        if cls.bearer:
            _check_name(cls.bearer, name)
        return cls._build(name, ())


class StateSymbol(NamedSymbol):
    """The value of an auxiliary state, such as a motor's current."""

    bearer = "state"


class ForceSymbol(NamedSymbol):
    """The multiplier of a constraint, named after it; it occurs in requirements only."""


class InputSymbol(NamedSymbol):
    """The value of an input of the machine, in the input's unit."""

    def _latex(self, printer: Any) -> str:
        symbol = str(printer._print(sympy.Symbol(self.name)))
        return rf"\mathrm{{{symbol}}}" if len(symbol) > 1 and symbol == self.name else symbol


class ReferenceSymbol(NamedSymbol):
    """The value of a reference of a feedback law, in the reference's unit."""

    bearer = "reference"


@checked
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
        name: Its name in scenarios, files and equations.
        lower: Lower limit in [m].
        upper: Upper limit in [m].
        speed: Largest magnitude of its rate, in [m/s].
        scale: Characteristic magnitude in [m]; distances are divided by it.
    """
    return Coordinate(name, "line", "m", (float(lower), float(upper)), float(speed), float(scale))


@checked
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
        name: Its name in scenarios, files and equations.
        lower: Lower limit in [rad]; an angle with a limit does not wrap.
        upper: Upper limit in [rad].
        speed: Largest magnitude of its rate in [rad/s].
        scale: Characteristic magnitude in [rad]; distances are divided by it.
    """
    limits = (float(lower), float(upper))
    topology: Topology = "circle" if all(map(math.isinf, limits)) else "line"
    return Coordinate(name, topology, "rad", limits, float(speed), float(scale))


def direction_entry(
    name: str,
    lower: float = -1.0,
    upper: float = 1.0,
    *,
    speed: float = math.inf,
    scale: float = 1.0,
) -> Coordinate:
    """Declare one entry of the unit vector of a direction; users call ``direction``."""
    return Coordinate(name, "sphere", "", (lower, upper), float(speed), float(scale))


@checked
def direction(
    name: str, *, speed: float = math.inf, scale: float = 1.0
) -> tuple[Coordinate, Coordinate, Coordinate]:
    """Declare a direction, a coordinate on the sphere S^2: the entries of a unit vector.

    They are used like any coordinate, as in ``move(l * x, l * y, l * z)`` for a pendulum. The
    machine gets the constraint that their squares add up to 1, and keeps every rate as a state.

    Args:
        name: Of the direction; its entries are named ``d_x``, ``d_y`` and ``d_z`` after a ``d``.
        speed: Largest magnitude of each entry's rate, in [1/s].
        scale: Characteristic chord; distances are divided by it.

    Source: Lee, Leok, McClamroch, Global Formulations of Lagrangian and Hamiltonian Dynamics on
    Manifolds, 2018, chapter 5.
    """
    x, y, z = (direction_entry(f"{name}_{axis}", speed=speed, scale=scale) for axis in "xyz")
    return x, y, z


@checked
def clock(
    name: str = "time",
    lower: float = 0.0,
    upper: float = math.inf,
    *,
    speed: float = math.inf,
    scale: float = 1.0,
) -> Coordinate:
    """Declare the time since the start, in [s], as a coordinate whose rate is 1.

    Frames and constraints in which it occurs move as time says, whatever the machine does: a
    driven pivot, a belt, an obstacle (``Body(prescribed=True)``).

    Args:
        name: Its name in scenarios, files and equations.
        lower: When it starts, in [s].
        upper: The longest motion that is looked at, in [s].
        speed: Of no use: its rate is 1.
        scale: Characteristic time in [s]; distances are divided by it.

    Source: LaValle, Planning Algorithms, 2006, section 7.1 (the state space X times T); Goldstein,
    Poole, Safko, Classical Mechanics, 3rd ed., 2002, section 1.3 (rheonomic constraints).
    """
    return Coordinate(name, "line", "s", (float(lower), float(upper)), float(speed), float(scale))


# what declares a coordinate, by its unit
KINDS = {"m": length, "rad": angle, "": direction_entry, "s": clock}


@checked
def rotation(name: str, *, speed: float = math.inf, scale: float = 1.0) -> Attitude:
    """Declare a coordinate on SO(3), to be used as a frame by ``orient``.

    Args:
        name: Its name in scenarios, files and equations.
        speed: Largest magnitude of each component of its angular velocity, in [rad/s].
        scale: Characteristic rotation angle in [rad]; distances are divided by it.
    """
    _check_coordinate(name, (-math.inf, math.inf), speed, scale)
    return Attitude(name, float(speed), float(scale), next(_serial))


@checked
def turn_rate(attitude: Attitude) -> tuple[TurnRate, TurnRate, TurnRate]:
    """Return the components of an attitude's angular velocity, in body axes, in [rad/s]."""
    return attitude.turn_rate


@checked
def parameter(name: str, default: float, unit: str = "") -> Parameter:
    """Declare a constant of the machine, such as a mass.

    Args:
        name: Its name in scenarios and equations.
        default: Its value where none is given, in ``unit``.
        unit: SI unit as text; left out if dimensionless.
    """
    return Parameter(name, default, unit)


@checked
def rate(coordinate: Coordinate) -> RateSymbol:
    """Return the symbol of the coordinate's time derivative."""
    return RateSymbol(coordinate)


@checked
def acceleration(coordinate: Coordinate) -> Acceleration:
    """Return the symbol of the coordinate's second time derivative, for hand derivations."""
    return Acceleration(coordinate)


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
