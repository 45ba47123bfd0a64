"""A machine as data: bodies, what constrains them and what acts on them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import sympy

from kinolab.dynamics.bodies import Body
from kinolab.dynamics.constraints import Constraint
from kinolab.dynamics.efforts import Gravity, Input
from kinolab.dynamics.symbols import Coordinate, Parameter, Rate
from kinolab.errors import InputError, Mistake, unknown_name

if TYPE_CHECKING:
    from kinolab.dynamics.equations import Equations
    from kinolab.dynamics.model import Model


@dataclass(frozen=True, init=False)
class System:
    """A mechanical system, frozen.

    Args:
        name: What scenarios call it.
        bodies: Everything that has mass or shape.
        constraints: Velocities that stay zero.
        inputs: What the planner decides, in this order.
        gravity: The uniform field, if any; it also tells pictures which way is up.
        velocities: The coordinates whose rates describe the motion; chosen by kinolab where the
            author leaves it out, and all of them where there is no constraint.
        coordinates: Their order; by default the order in which they were made.
        values: Parameter values other than the defaults, by name.

    Raises:
        InputError: With every mistake in the description.
    """

    name: str
    bodies: tuple[Body, ...]
    constraints: tuple[Constraint, ...]
    inputs: tuple[Input, ...]
    gravity: Gravity | None
    velocities: tuple[Coordinate, ...] | None
    coordinates: tuple[Coordinate, ...]
    parameters: tuple[Parameter, ...]
    values: tuple[tuple[str, float], ...]

    def __init__(
        self,
        name: str,
        *,
        bodies: Sequence[Body],
        constraints: Sequence[Constraint] = (),
        inputs: Sequence[Input] = (),
        gravity: Gravity | None = None,
        velocities: Sequence[Coordinate] | None = None,
        coordinates: Sequence[Coordinate] | None = None,
        values: Mapping[str, float] | None = None,
    ) -> None:
        parts = (tuple(bodies), tuple(constraints), tuple(inputs), gravity)
        symbols = set(_symbols(parts))
        if coordinates is None:
            named = {s.coordinate if isinstance(s, Rate) else s for s in symbols}
            used = (s for s in named if isinstance(s, Coordinate))
            coordinates = sorted(used, key=lambda coordinate: coordinate.serial)
        parameters = sorted((s for s in symbols if isinstance(s, Parameter)), key=str)
        fields = {
            "name": name,
            "bodies": parts[0],
            "constraints": parts[1],
            "inputs": parts[2],
            "gravity": gravity,
            "velocities": None if velocities is None else tuple(velocities),
            "coordinates": tuple(coordinates),
            "parameters": tuple(parameters),
            "values": tuple(sorted((values or {}).items())),
        }
        for field, value in fields.items():
            object.__setattr__(self, field, value)
        mistakes = list(_mistakes(self, symbols))
        if mistakes:
            raise InputError(mistakes)

    def with_parameters(self, **values: float) -> System:
        """Return the same machine with other parameter values; nothing is derived anew.

        Raises:
            UnknownNameError: If a parameter does not exist.
        """
        return replace_values(self, dict(self.values) | values)

    @property
    def parameter_values(self) -> dict[str, float]:
        """Every parameter's value in its SI unit, by name."""
        return {p.name: p.default for p in self.parameters} | dict(self.values)

    def number(self, expression: Any) -> float:
        """Evaluate an expression in parameters alone."""
        values = self.parameter_values
        named = {parameter: values[parameter.name] for parameter in self.parameters}
        return float(sympy.sympify(expression).subs(named))

    def body(self, name: str) -> Body:
        """Return a body by its name."""
        return next(body for body in self.bodies if body.name == name)

    def model(self) -> Model:
        """Derive and compile the equations of motion."""
        from kinolab.dynamics.model import Model

        return Model(self)

    def equations(self) -> Equations:
        """Return the equations of motion for reading, in the author's symbols."""
        from kinolab.dynamics.equations import equations_of

        return equations_of(self)


def replace_values(system: System, values: Mapping[str, float]) -> System:
    """Return a copy of a system with exactly these parameter values set."""
    return System(
        system.name,
        bodies=system.bodies,
        constraints=system.constraints,
        inputs=system.inputs,
        gravity=system.gravity,
        velocities=system.velocities,
        coordinates=system.coordinates,
        values=values,
    )


def resolved_shapes(system: System, body: Body) -> tuple[Any, ...]:
    """Return a body's shapes with their dimensions as numbers."""

    def number(value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(number(entry) for entry in value)
        return value if isinstance(value, str) else system.number(value)

    return tuple(
        replace(shape, **{field: number(value) for field, value in vars(shape).items()})
        for shape in body.shapes
    )


def _symbols(part: Any) -> Iterator[sympy.Symbol]:
    """Yield every symbol in a tree of dataclasses, tuples and expressions."""
    if isinstance(part, sympy.Basic):
        yield from part.free_symbols
    elif isinstance(part, tuple):
        for entry in part:
            yield from _symbols(entry)
    elif hasattr(part, "__dataclass_fields__"):
        yield from _symbols(tuple(getattr(part, field) for field in part.__dataclass_fields__))


def _mistakes(system: System, symbols: set[sympy.Symbol]) -> Iterator[Mistake]:
    yield from _naming_mistakes(system)
    yield from _value_mistakes(system)
    if not system.bodies:
        yield Mistake(f"system {system.name!r}", "it has no bodies.")
    listed = set(system.coordinates)
    for symbol in sorted(symbols, key=str):
        coordinate = symbol.coordinate if isinstance(symbol, Rate) else symbol
        if isinstance(coordinate, Coordinate):
            if coordinate not in listed:
                what = f"the coordinate {coordinate} is used but not listed in coordinates."
                yield Mistake(f"system {system.name!r}", what)
        elif not isinstance(symbol, Parameter):
            remedy = "Make it with length, angle, parameter or rate."
            what = f"the symbol {symbol} is not declared."
            yield Mistake(f"system {system.name!r}", what, remedy)
    for coordinate in system.velocities or ():
        if coordinate not in listed:
            what = f"{coordinate} is named in velocities but is no coordinate of the machine."
            yield Mistake(f"system {system.name!r}", what)
    for body in system.bodies:
        yield from _body_mistakes(system, body)


def _naming_mistakes(system: System) -> Iterator[Mistake]:
    rates = [f"{coordinate.name}_dot" for coordinate in system.coordinates]
    symbols = [s.name for s in (*system.coordinates, *system.parameters, *system.inputs)]
    for kind, names in (
        ("coordinate, rate, parameter or input", symbols + rates),
        ("body", [body.name for body in system.bodies]),
    ):
        for name, count in Counter(names).items():
            if count > 1:
                remedy = "Give each a name of its own."
                yield Mistake(f"{kind} {name!r}", f"{count} have this name.", remedy)


def _value_mistakes(system: System) -> Iterator[Mistake]:
    known = [parameter.name for parameter in system.parameters]
    for name, value in system.values:
        if name not in known:
            where = f"system {system.name!r}"
            yield unknown_name("parameter", name, known=known, where=where)
        elif not isinstance(value, int | float) or not math.isfinite(value):
            yield Mistake(f"parameter {name!r}", f"its value is {value!r}.", "Give a number.")


def _body_mistakes(system: System, body: Body) -> Iterator[Mistake]:
    where = f"body {body.name!r}"
    try:
        mass = system.number(body.mass)
        a, b, c = sorted(system.number(moment) for moment in body.inertia)
    except (TypeError, KeyError):
        what = "its mass or inertia depends on more than numbers and parameters."
        yield Mistake(where, what)
        return
    if mass < 0:
        yield Mistake(where, f"its mass is {mass:g} kg.", "A mass is 0 or positive.")
    if a < 0 or a + b < c * (1 - 1e-9):
        what = f"no rigid body has the principal moments {a:g}, {b:g}, {c:g} kg m^2."
        remedy = "Each must be at least 0 and at most the sum of the other two."
        yield Mistake(where, what, remedy)


def names_of(symbols: Iterable[sympy.Symbol]) -> tuple[str, ...]:
    """Return the names of symbols."""
    return tuple(symbol.name for symbol in symbols)
