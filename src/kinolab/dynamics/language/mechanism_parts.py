"""The fields of a mechanism, its symbols and parameter values, before validation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias

import sympy

from kinolab.dynamics.language.auxiliary_states import State
from kinolab.dynamics.language.bodies import Body, Cable
from kinolab.dynamics.language.constraints import Constraint, PositionConstraint, Requirement
from kinolab.dynamics.language.expressions import exact, parts_of
from kinolab.dynamics.language.feedback import Feedback, Regulator
from kinolab.dynamics.language.flatness import Flat
from kinolab.dynamics.language.forces import Effort, Gravity
from kinolab.dynamics.language.inputs import Input
from kinolab.dynamics.language.modes import Mode, Transition
from kinolab.dynamics.language.quasi_velocities import QuasiVelocity
from kinolab.dynamics.language.symbols import (
    Attitude,
    Coordinate,
    Parameter,
    QuaternionEntry,
    RateSymbol,
    TurnRate,
    rate,
)
from kinolab.errors import InputError, Mistake

AnyCoordinate: TypeAlias = Coordinate | Attitude


@dataclass(frozen=True)
class MechanismParts:
    """The fields of a machine, documented in ``Mechanism``."""

    name: str
    bodies: tuple[Body, ...]
    constraints: tuple[Constraint, ...]
    inputs: tuple[Input, ...]
    efforts: tuple[Effort, ...]
    gravity: Gravity | None
    states: tuple[State, ...]
    requirements: tuple[Requirement, ...]
    collisions: tuple[tuple[str, str], ...]
    unwatched: tuple[tuple[str, str], ...]
    cables: tuple[Cable, ...]
    velocities: tuple[AnyCoordinate | QuasiVelocity, ...] | Literal["all"] | None
    coordinates: tuple[AnyCoordinate, ...]
    parameters: tuple[Parameter, ...]
    values: tuple[tuple[str, float], ...]
    flat: Flat | None
    feedback: Feedback | Regulator | None
    modes: tuple[Mode, ...]
    transitions: tuple[Transition, ...]

    @property
    def parameter_values(self) -> dict[str, float]:
        """Every parameter's value in its SI unit, by name."""
        return {p.name: p.default for p in self.parameters} | dict(self.values)

    @property
    def all_constraints(self) -> tuple[Constraint, ...]:
        """The constraints that hold always, then those of each mode."""
        return (*self.constraints, *(c for mode in self.modes for c in mode.constraints))

    @property
    def closures(self) -> tuple[PositionConstraint, ...]:
        """The position constraints that hold always."""
        return tuple(c for c in self.constraints if isinstance(c, PositionConstraint))

    @property
    def all_requirements(self) -> tuple[Requirement, ...]:
        """The requirements that hold always, then those of each mode."""
        return (*self.requirements, *(r for mode in self.modes for r in mode.requirements))

    def number(self, expression: Any) -> float:
        """Evaluate an expression in parameters only."""
        stated, values = exact(expression), self.parameter_values
        known = (entry for entry in stated.atoms(Parameter) if entry.name in values)
        named = [(entry, values[entry.name]) for entry in known]
        return float(stated.subs(named) if named else stated)

    def resolved_shapes(self, body: Body) -> tuple[Any, ...]:
        """Return a body's shapes with numeric dimensions."""

        def number(value: Any) -> Any:
            if isinstance(value, tuple):
                return tuple(number(entry) for entry in value)
            return value if isinstance(value, str) else self.number(value)

        return tuple(
            replace(shape, **{field: number(value) for field, value in vars(shape).items()})
            for shape in body.shapes
        )


def require_one_mode(system: MechanismParts) -> None:
    """Require that a machine has the same equations of motion everywhere.

    Raises:
        InputError: If it has modes.
    """
    if system.modes:
        remedy = f'Take one of them: in_mode(system, "{system.modes[0].name}").'
        what = "its equations of motion are different in each of its modes."
        raise InputError([Mistake(f"system {system.name!r}", what, remedy)])


def configuration_symbols(system: MechanismParts) -> tuple[sympy.Symbol, ...]:
    """Return the symbols of q in order; four for an attitude."""
    return tuple(
        symbol
        for c in system.coordinates
        for symbol in ((c,) if isinstance(c, Coordinate) else c.quaternion)
    )


def tangent_symbols(system: MechanismParts) -> tuple[sympy.Symbol, ...]:
    """Return the symbols of the velocities in order; three for an attitude."""
    return tuple(
        symbol
        for c in system.coordinates
        for symbol in ((rate(c),) if isinstance(c, Coordinate) else c.turn_rate)
    )


def quasi_velocities(system: MechanismParts) -> tuple[QuasiVelocity, ...]:
    """Return the quasi-velocities that the author chose as independent velocities."""
    if system.velocities is None or isinstance(system.velocities, str):
        return ()
    return tuple(v for v in system.velocities if isinstance(v, QuasiVelocity))


def state_symbols(
    system: MechanismParts, quasi: Sequence[sympy.Symbol], independent: Sequence[int]
) -> tuple[sympy.Symbol, ...]:
    """Return the symbols of a state x in order.

    Args:
        system: The machine.
        quasi: The symbols of quasi-velocities that are states.
        independent: Indices, among all velocities, of those that are.
    """
    rates = tangent_symbols(system)
    further = (entry.symbol for entry in system.states)
    chosen = (rates[i] for i in independent)
    return (*configuration_symbols(system), *quasi, *chosen, *further)


def atoms_of(part: Any) -> Iterator[sympy.Symbol | Attitude]:
    """Yield every symbol and attitude in a tree of dataclasses, tuples and expressions."""
    if isinstance(part, sympy.Basic):
        yield from (entry for entry in parts_of((part,)) if isinstance(entry, sympy.Symbol))
    elif isinstance(part, tuple):
        for entry in part:
            yield from atoms_of(entry)
    elif isinstance(part, Attitude):
        yield part
    elif hasattr(part, "__dataclass_fields__"):
        yield from atoms_of(tuple(getattr(part, name) for name in part.__dataclass_fields__))


def coordinate_of(atom: sympy.Symbol | Attitude) -> AnyCoordinate | None:
    """Return the coordinate that a symbol belongs to, if any."""
    if isinstance(atom, RateSymbol):
        return atom.coordinate
    if isinstance(atom, QuaternionEntry | TurnRate):
        return atom.attitude
    return atom if isinstance(atom, Coordinate | Attitude) else None
