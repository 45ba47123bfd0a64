"""From a machine's description to its equations of motion in multipliers: energies as formulas."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import sympy

from kinolab.dynamics.lagrange.energies import (
    kinetic_energy,
    potential_energy,
    pulls,
    ropes,
    velocity_loads,
)
from kinolab.dynamics.lagrange.hyper_dual import FUNCTIONS, Instruction
from kinolab.dynamics.lagrange.multiplier_form import ImposedVelocity, MultiplierForm
from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.dynamics.language.expressions import exact
from kinolab.dynamics.language.forces import Rope
from kinolab.dynamics.language.frames import time_derivative
from kinolab.dynamics.language.inputs import Drive, Rate
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import tangent_symbols
from kinolab.dynamics.language.quasi_velocities import QuasiVelocity, QuasiVelocitySymbol
from kinolab.dynamics.language.symbols import Coordinate
from kinolab.errors import InputError, Mistake


def multiplier_form(
    system: Mechanism, quasi: Sequence[QuasiVelocity], rates: Sequence[str]
) -> MultiplierForm:
    """Derive a machine's equations of motion in all velocities and multipliers.

    Args:
        system: The machine, in one mode and without feedback.
        quasi: The quasi-velocities that are states.
        rates: Names of the rates that are states, after those.

    Raises:
        InputError: If it has a function that kinolab does not know.
    """
    place = _Writing()
    velocities = tangent_symbols(system)
    names = [symbol.name for symbol in velocities]
    kinetic = kinetic_energy(system)
    states = [*(v.velocity for v in quasi), *(velocities[names.index(name)] for name in rates)]
    values = system.parameter_values
    return MultiplierForm(
        kinetic=None if kinetic == 0 else place(kinetic),
        potential=place(potential_energy(system)),
        position_loads=(
            *(tuple(map(place, load)) for load in pulls(system)),
            *(place.pull_of(rope) for rope in ropes(system)),
        ),
        velocity_loads=tuple(tuple(map(place, load)) for load in velocity_loads(system)),
        imposed=tuple(
            ImposedVelocity(place(velocity), place(equals), place(change))
            for velocity, equals, change in _imposed(system)
        ),
        driven=tuple(
            (names.index(f"{entry.on.name}_dot"), place(entry.symbol))
            for entry in system.inputs
            if isinstance(entry, Drive)
        ),
        states=tuple(map(place, states)),
        further=tuple(place(entry.derivative) for entry in system.states),
        instructions=tuple(place.instructions),
        coordinates=tuple(
            (c.name,) if isinstance(c, Coordinate) else tuple(e.name for e in c.quaternion)
            for c in system.coordinates
        ),
        velocities=tuple(names),
        inputs=tuple(entry.name for entry in system.inputs),
        further_names=tuple(entry.name for entry in system.states),
        parameters=tuple((p.name, values[p.name]) for p in system.parameters),
    )


def _imposed(system: Mechanism) -> Iterator[tuple[Any, Any, Any]]:
    """Yield what is imposed on velocities, what they equal, and its change; inputs are held."""
    for constraint in system.constraints:
        if isinstance(constraint, PositionConstraint):
            yield time_derivative(exact(constraint.position)), 0, 0
        else:
            yield constraint.velocity, 0, 0
    for entry in system.inputs:
        if isinstance(entry, Rate):
            yield entry.velocity, entry.symbol, 0
    for state in system.states:
        if state.velocity is not None:
            yield state.velocity, state.symbol, state.derivative


class _Writing:
    """Writes expressions as instructions, each subexpression once."""

    def __init__(self) -> None:
        self.instructions: list[Instruction] = []
        self._places: dict[sympy.Expr, int] = {}

    def __call__(self, expression: Any) -> int:
        """Return the place of an expression, written if it is new.

        Raises:
            InputError: If it has a function that kinolab does not know.
        """
        stated = exact(expression)
        if stated not in self._places:
            self._places[stated] = self._written(self._instruction(stated))
        return self._places[stated]

    def pull_of(self, rope: Rope) -> tuple[int, int]:
        """Write what a rope pulls with, and its stretch, which is not differentiated here."""
        stretch = self(rope.stretch)
        s, s_dot = sympy.symbols("s s_dot", real=True, cls=sympy.Dummy)
        self._places[s] = stretch
        self._places[s_dot] = self._written(Instruction("change", (stretch,)))
        return self(-rope.tension_at(s, s_dot)), stretch

    def _written(self, instruction: Instruction) -> int:
        self.instructions.append(instruction)
        return len(self.instructions) - 1

    def _instruction(self, expression: sympy.Expr) -> Instruction:
        if expression.is_number:
            return Instruction("number", number=float(expression))
        if isinstance(expression, QuasiVelocitySymbol):
            return Instruction("add", (self(expression.velocity),))
        if expression.is_Symbol:
            return Instruction("variable", label=expression.name)
        if isinstance(expression, sympy.Pow):
            base, exponent = expression.args
            if exponent.is_number:
                return Instruction("power", (self(base),), float(exponent))
            return self._instruction(sympy.exp(exponent * sympy.log(base), evaluate=False))
        operands = tuple(map(self, expression.args))
        for name, kind in (("add", sympy.Add), ("mul", sympy.Mul), ("max", sympy.Max)):
            if isinstance(expression, kind):
                return Instruction(name, operands)
        name = expression.func.__name__
        if name not in FUNCTIONS:
            what = f"{name} cannot be evaluated."
            raise InputError([Mistake(f"{expression}"[:60], what)])
        return Instruction(name, operands[:1])
