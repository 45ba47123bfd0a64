"""A machine as data: bodies, what constrains them and what acts on them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.auxiliary_states import State
from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.cables import AnyCable, Cable, as_cables
from kinolab.dynamics.language.constraints import Constraint, Requirement
from kinolab.dynamics.language.expressions import exact
from kinolab.dynamics.language.feedback import Feedback, Regulator
from kinolab.dynamics.language.flatness import Flat
from kinolab.dynamics.language.forces import Effort, Gravity
from kinolab.dynamics.language.inputs import Input
from kinolab.dynamics.language.symbols import (
    Attitude,
    Coordinate,
    Parameter,
    QuaternionEntry,
    RateSymbol,
    TurnRate,
)
from kinolab.errors import InputError

if TYPE_CHECKING:
    from kinolab.dynamics.lagrange.agreement import Agreement
    from kinolab.dynamics.lagrange.equations import Equations
    from kinolab.dynamics.model import Model

AnyCoordinate: TypeAlias = Coordinate | Attitude


@checked
@dataclass(frozen=True, init=False)
class System:
    """A mechanical system, frozen; several separate mechanisms may be in one.

    Args:
        name: What scenarios call it.
        bodies: Everything that has mass or shape.
        constraints: What stays zero, held by forces: ``zero(velocity)``, ``closed(position)``.
        inputs: What the planner decides, in this order.
        efforts: What else acts: springs, friction, buoyancy, wrenches.
        gravity: The uniform field, if any; it also tells pictures which way is up.
        states: Further states with differential equations of their own.
        requirements: What plans must keep: ``require(margin, name)``.
        collisions: Pairs of bodies or cables that may not touch each other, by name.
        cables: Ropes and strings; a pair of frames stands for a ``Cable`` between them.
        velocities: The coordinates whose rates describe the motion. Left out, kinolab chooses
            them where constraints leave a choice. ``"all"`` keeps every rate as a state and finds
            the constraints' forces as multipliers, where no fixed choice serves everywhere.
        coordinates: Their order; by default the order in which they were made.
        values: Parameter values other than the defaults, by name.
        flat: How its motions follow from curves, where they do; planners steer by it.
        feedback: The controller that is part of the machine, if it has one: planners then choose
            its references, and the inputs follow.

    Raises:
        InputError: With every mistake in the description.
    """

    name: str
    bodies: tuple[Body, ...]
    constraints: tuple[Constraint, ...]
    inputs: tuple[Input, ...]
    efforts: tuple[Effort, ...]
    gravity: Gravity | None
    states: tuple[State, ...]
    requirements: tuple[Requirement, ...]
    collisions: tuple[tuple[str, str], ...]
    cables: tuple[Cable, ...]
    velocities: tuple[AnyCoordinate, ...] | Literal["all"] | None
    coordinates: tuple[AnyCoordinate, ...]
    parameters: tuple[Parameter, ...]
    values: tuple[tuple[str, float], ...]
    flat: Flat | None
    feedback: Feedback | Regulator | None

    def __init__(
        self,
        name: str,
        *,
        bodies: Sequence[Body],
        constraints: Sequence[Constraint] = (),
        inputs: Sequence[Input] = (),
        efforts: Sequence[Effort] = (),
        gravity: Gravity | None = None,
        states: Sequence[State] = (),
        requirements: Sequence[Requirement] = (),
        collisions: Sequence[tuple[str, str]] = (),
        cables: Sequence[AnyCable] = (),
        velocities: Sequence[AnyCoordinate] | Literal["all"] | None = None,
        coordinates: Sequence[AnyCoordinate] | None = None,
        values: Mapping[str, Any] | None = None,  # each is judged with its parameter
        flat: Flat | None = None,
        feedback: Feedback | Regulator | None = None,
    ) -> None:
        from kinolab.dynamics.language.validation import mistakes_of

        content = {
            "bodies": tuple(bodies),
            "constraints": tuple(constraints),
            "inputs": tuple(inputs),
            "efforts": tuple(efforts),
            "gravity": gravity,
            "states": tuple(states),
            "requirements": tuple(requirements),
            "cables": as_cables(tuple(cables)),
            "feedback": feedback,
        }
        atoms = set(atoms_of(tuple(content.values())))
        used = {a for a in map(_coordinate_of, atoms) if a is not None}
        given = {
            "name": name,
            **content,
            "collisions": tuple((a, b) for a, b in collisions),
            "velocities": tuple(velocities)
            if velocities is not None and not isinstance(velocities, str)
            else velocities,
            "coordinates": tuple(sorted(used, key=lambda c: c.serial))
            if coordinates is None
            else tuple(coordinates),
            "parameters": tuple(sorted((a for a in atoms if isinstance(a, Parameter)), key=str)),
            "values": tuple(sorted((values or {}).items())),
            "flat": flat,
        }
        for field, value in given.items():
            object.__setattr__(self, field, value)
        mistakes = list(mistakes_of(self, atoms, used))
        if mistakes:
            raise InputError(mistakes)

    def with_parameters(self, **values: float) -> System:
        """Return the same machine with other parameter values; nothing is derived anew.

        Raises:
            InputError: If a parameter does not exist or a value is not a number.
        """
        return self._changed(values=dict(self.values) | values)

    def with_feedback(self, feedback: Feedback | Regulator | None) -> System:
        """Return the same machine with another controller, or with none.

        Raises:
            InputError: If the controller does not fit the machine.
        """
        return self._changed(feedback=feedback)

    def with_inputs(self, inputs: Sequence[Input], feedback: Feedback | Regulator | None) -> System:
        """Return the same machine with other limits of its inputs, and another controller."""
        return self._changed(inputs=tuple(inputs), feedback=feedback)

    def _changed(self, **content: Any) -> System:
        own = {field.name: getattr(self, field.name) for field in fields(self)}
        del own["parameters"]  # they follow from the rest
        return System(**own | {"values": dict(self.values)} | content)

    @property
    def parameter_values(self) -> dict[str, float]:
        """Every parameter's value in its SI unit, by name."""
        return {p.name: p.default for p in self.parameters} | dict(self.values)

    def number(self, expression: Any) -> float:
        """Evaluate an expression in parameters alone."""
        stated, values = exact(expression), self.parameter_values
        known = (entry for entry in stated.atoms(Parameter) if entry.name in values)
        named = [(entry, values[entry.name]) for entry in known]
        return float(stated.subs(named) if named else stated)

    def resolved_shapes(self, body: Body) -> tuple[Any, ...]:
        """Return a body's shapes with their dimensions as numbers."""

        def number(value: Any) -> Any:
            if isinstance(value, tuple):
                return tuple(number(entry) for entry in value)
            return value if isinstance(value, str) else self.number(value)

        return tuple(
            replace(shape, **{field: number(value) for field, value in vars(shape).items()})
            for shape in body.shapes
        )

    def model(self) -> Model:
        """Derive and compile the equations of motion."""
        from kinolab.dynamics.model import Model

        return Model(self)

    def equations(self) -> Equations:
        """Return the equations of motion for reading, in the author's symbols."""
        from kinolab.dynamics.lagrange.equations import equations_of

        return equations_of(self)

    def agrees_with(self, equations: Sequence[sympy.Eq | sympy.Expr]) -> Agreement:
        """Hold a hand derivation against kinolab's own and name the terms that differ.

        Args:
            equations: Equations of motion in the machine's symbols, with ``acceleration(x)`` for
                second derivatives and input symbols for inputs, in any order and each up to a
                factor; with multipliers lambda_1, … or without.

        Returns:
            True or False, with ``.verdicts`` in words.
        """
        from kinolab.dynamics.lagrange.agreement import compare

        return compare(self.equations(), equations)

    def _repr_latex_(self) -> str:
        return self.equations().latex()


def atoms_of(part: Any) -> Iterator[sympy.Symbol | Attitude]:
    """Yield every symbol and attitude in a tree of dataclasses, tuples and expressions."""
    if isinstance(part, sympy.Basic):
        yield from part.free_symbols
    elif isinstance(part, tuple):
        for entry in part:
            yield from atoms_of(entry)
    elif isinstance(part, Attitude):
        yield part
    elif hasattr(part, "__dataclass_fields__"):
        yield from atoms_of(tuple(getattr(part, name) for name in part.__dataclass_fields__))


def _coordinate_of(atom: sympy.Symbol | Attitude) -> AnyCoordinate | None:
    """Return the coordinate that a symbol belongs to, if any."""
    if isinstance(atom, RateSymbol):
        return atom.coordinate
    if isinstance(atom, QuaternionEntry | TurnRate):
        return atom.attitude
    return atom if isinstance(atom, Coordinate | Attitude) else None
