"""The fields of a mechanism, its symbols and parameter values, and what its forces come down to.

All that derives or writes a machine asks here for potentials, loads and imposed motions, and knows
no force or input by its name.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
import sympy

from kinolab.dynamics.language.bodies import Body, Cable
from kinolab.dynamics.language.constraints import Constraint, PositionConstraint, Requirement
from kinolab.dynamics.language.feedback import Feedback, Regulator
from kinolab.dynamics.language.flatness import Flat
from kinolab.dynamics.language.forces import Effort, Gravity, Load, Potential
from kinolab.dynamics.language.inputs import Drive, Input, Rate
from kinolab.dynamics.language.modes import Mode, Transition
from kinolab.dynamics.language.offer import Offer, offered
from kinolab.dynamics.language.quantities import UP, FrameQuantity, written
from kinolab.dynamics.language.quasi_velocities import QuasiVelocity, State
from kinolab.dynamics.language.shapes import Hull, Shape
from kinolab.dynamics.symbols.expressions import as_written, exact, parts_of
from kinolab.dynamics.symbols.symbols import (
    Attitude,
    Coordinate,
    Parameter,
    QuaternionEntry,
    RateSymbol,
    TurnRate,
    rate,
)
from kinolab.dynamics.symbols.words import LoweredWord, primitives_of
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.state_parts import Part

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
    notes: tuple[tuple[str, str], ...]
    cables: tuple[Cable, ...]
    velocities: tuple[AnyCoordinate | QuasiVelocity, ...] | Literal["all"] | None
    coordinates: tuple[AnyCoordinate, ...]
    parameters: tuple[Parameter, ...]
    values: tuple[tuple[str, float], ...]
    keep: tuple[str, ...]
    flat: Flat | None
    feedback: Feedback | Regulator | None
    modes: tuple[Mode, ...]
    transitions: tuple[Transition, ...]
    expected: tuple[str, ...]
    offers: tuple[Offer, ...]

    @property
    def parameter_values(self) -> dict[str, float]:
        """Every parameter's value in its SI unit, by name."""
        return {p.name: p.default for p in self.parameters} | dict(self.values)

    @property
    def offered(self) -> dict[str, float]:
        """The values of its numbers that are parameters, or become such, by name."""
        return {name: p.default for name, (p, _) in offered(self.offers).items()}

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

    def inertia_of(self, body: Body) -> Array:
        """Return a body's inertia about its centre of mass, in its axes, in [kg m^2], (3, 3)."""
        return np.array([self.number(entry) for entry in body.inertia_matrix]).reshape(3, 3)

    @property
    def down(self) -> tuple[float, float, float] | None:
        """The direction of gravity, a unit vector of the world; None where there is none."""
        if self.gravity is None:
            return None
        x, y, z = map(self.number, self.gravity.down)
        return x, y, z

    def resolved_shapes(self, body: Body) -> tuple[Shape, ...]:
        """Return a body's shapes with numeric dimensions; those from outside are hulls."""
        return tuple(map(self.resolved_shape, body.shapes))

    def resolved_shape(self, shape: Shape) -> Shape:
        """Return a shape with numeric dimensions; one from outside is a hull.

        Raises:
            InputError: If there is no such solid.
        """

        def number(value: Any) -> Any:
            if isinstance(value, tuple):
                return tuple(number(entry) for entry in value)
            return self.number(value)

        numbers = {name: number(getattr(shape, name)) for name in (*shape.lengths(), "at")}
        try:
            return replace(shape, **numbers).kept()
        except InputError:
            raise
        except Exception as error:
            what = f"it cannot be made of its own fields ({type(error).__name__}: {error})."
            remedy = "Write a frozen dataclass, with dimensions, at and axis."
            raise InputError([Mistake(f"class {shape.called}", what, remedy)]) from error

    @property
    def substitutions(self) -> dict[Any, float]:
        """What SymPy puts in for parameters: the value of each."""
        return {p: self.parameter_values[p.name] for p in self.parameters}

    def kept_shapes(self, body: Body) -> tuple[Shape, ...]:
        """Return a body's shapes as files keep them: dimensions of hulls follow no parameter."""
        return tuple(
            self._made_for(shape, found) if isinstance(found, Hull) else shape
            for shape, found in zip(body.shapes, self.resolved_shapes(body), strict=True)
        )

    def _made_for(self, shape: Shape, hull: Hull) -> Hull:
        """Return a shape's hull at its place, with the parameters that the shape depends on."""
        sizes = tuple(exact(getattr(shape, name)) for name in shape.lengths())
        used = sorted((p for p in set(atoms_of(sizes)) if isinstance(p, Parameter)), key=str)
        values = tuple((p, self.parameter_values[p.name]) for p in used)
        return replace(hull, at=shape.at, made_for=getattr(shape, "made_for", values))


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
    return tuple(symbol for c in system.coordinates for symbol in c.entries)


def tangent_symbols(system: MechanismParts) -> tuple[sympy.Symbol, ...]:
    """Return the symbols of the velocities in order; three for an attitude."""
    return tuple(symbol for c in system.coordinates for symbol in c.rates)


def state_parts(system: MechanismParts) -> tuple[Part, ...]:
    """Return the parts of a configuration in order, of which one may be several coordinates."""
    parts: list[Part] = []
    place = 0
    for c in system.coordinates:
        if place == (parts[-1].own.stop if parts else 0):
            parts.append(c.part(place))
        place += len(c.entries)
    return tuple(parts)


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
    """Yield every symbol and attitude in a tree of dataclasses, tuples and expressions.

    What a force or an input is lowered to is in it, and for a quantity of frames these are.
    """
    if isinstance(part, FrameQuantity):
        yield from atoms_of(part.facts)
    elif isinstance(part, sympy.Symbol):
        yield part
    elif isinstance(part, sympy.Basic):
        yield from atoms_of(tuple(e for e in parts_of((part,)) if isinstance(e, sympy.Symbol)))
    elif isinstance(part, tuple):
        for entry in part:
            yield from atoms_of(entry)
    elif isinstance(part, Attitude):
        yield part
    elif hasattr(part, "__dataclass_fields__"):
        yield from atoms_of(tuple(getattr(part, name) for name in part.__dataclass_fields__))
    if isinstance(part, LoweredWord) and not part.primitive:
        yield from (atom for atom in atoms_of(primitives_of(part)) if atom not in UP)


def coordinate_of(atom: sympy.Symbol | Attitude) -> AnyCoordinate | None:
    """Return the coordinate that a symbol belongs to, if any."""
    if isinstance(atom, RateSymbol):
        return atom.coordinate
    if isinstance(atom, QuaternionEntry | TurnRate):
        return atom.attitude
    return atom if isinstance(atom, Coordinate | Attitude) else None


class ImposedVelocity(NamedTuple):
    """A velocity, linear in the rates, that an input, an auxiliary state or time imposes.

    Attributes:
        where: What imposes it, for errors.
        velocity: The velocity.
        symbol: What it equals; 1 for the rate of a clock.
        change: The derivative of that; an input is held.
    """

    where: str
    velocity: sympy.Expr
    symbol: sympy.Symbol | sympy.Integer
    change: sympy.Expr


def primitives_in(system: MechanismParts) -> list[tuple[Any, ...]]:
    """Return what each input and force consists of, those of modes included."""
    always, sometimes = (*system.inputs, *system.efforts), (mode.efforts for mode in system.modes)
    return [primitives_of(word) for words in (always, *sometimes) for word in words]


def energies_in(word: Effort | Input) -> Iterator[sympy.Expr]:
    """Yield the potential energies of a force in [J]."""
    yield from (part.energy for part in primitives_of(word) if isinstance(part, Potential))


def loads_in(word: Effort | Input) -> Iterator[Load]:
    """Yield the loads of a force or an input."""
    yield from (part for part in primitives_of(word) if isinstance(part, Load))


def up_in(system: MechanismParts) -> dict[sympy.Symbol, sympy.Expr]:
    """Return the components of the unit vector against gravity; along z where there is none."""
    down = system.gravity.down if system.gravity is not None else (0, 0, -1)
    up = (-part if isinstance(part, sympy.Expr) else as_written(-part) for part in down)
    return dict(zip(UP, up, strict=True))


def potentials(system: MechanismParts) -> Iterator[sympy.Expr]:
    """Yield the potential energies of a machine's forces in [J], weight left out."""
    up = up_in(system)
    for effort in system.efforts:
        yield from (energy.xreplace(up) for energy in energies_in(effort))


def loads(system: MechanismParts, *, dry: bool = True) -> Iterator[tuple[Effort | Input, Load]]:
    """Yield the loads of a machine's forces and inputs, each with the force or input.

    Args:
        system: The machine.
        dry: Whether dry friction counts.
    """
    kept = [effort for effort in system.efforts if dry or not effort.dry]
    words: list[Effort | Input] = [*kept, *system.inputs]
    yield from ((word, load) for word in words for load in loads_in(word))


def dry_frictions(
    system: MechanismParts,
) -> Iterator[tuple[tuple[sympy.Expr, sympy.Expr], sympy.Expr]]:
    """Yield the slip in [m/s] and the strength in [N] of every dry friction.

    One along a line slides in it only.
    """
    for effort in system.efforts:
        if effort.dry:
            x, y = (*(load.velocity for load in loads_in(effort)), sympy.Integer(0))[:2]
            yield (x, y), exact(getattr(effort, effort.size))


def imposed_velocities(system: MechanismParts) -> list[ImposedVelocity]:
    """Return the velocities that inputs impose, those that auxiliary states do, and of clocks."""
    zero = sympy.Integer(0)
    rates = (part for entry in system.inputs for part in primitives_of(entry))
    return [
        *(
            ImposedVelocity(f"input {e.name!r}", written(e.velocity), e.symbol, zero)
            for e in rates
            if isinstance(e, Rate)
        ),
        *(
            ImposedVelocity(f"state {s.name!r}", exact(s.velocity), s.symbol, exact(s.derivative))
            for s in system.states
            if s.velocity is not None
        ),
        *(
            ImposedVelocity(f"clock {c.name!r}", rate(c), sympy.Integer(1), zero)
            for c in clocks(system)
        ),
    ]


def clocks(system: MechanismParts) -> list[Coordinate]:
    """Return the coordinates that are the time since the start."""
    return [c for c in system.coordinates if isinstance(c, Coordinate) and c.unit == "s"]


def imposed_accelerations(system: MechanismParts) -> dict[str, sympy.Symbol]:
    """Return the inputs that impose the accelerations of coordinates, by the coordinates' names."""
    parts = (part for entry in system.inputs for part in primitives_of(entry))
    return {part.on.name: part.symbol for part in parts if isinstance(part, Drive)}


def prescribes(entry: Input) -> bool:
    """Whether an input prescribes a motion, and is no symbol in loads."""
    return any(isinstance(part, Rate | Drive) for part in primitives_of(entry))
