"""From a machine's description to its equations of motion in multipliers: energies as formulas."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy

from kinolab.dynamics.lagrange.energies import kinetic_energy, weight_energy
from kinolab.dynamics.lagrange.hyper_dual import FUNCTIONS, Instruction
from kinolab.dynamics.lagrange.multiplier_form import MultiplierForm, VelocityRow
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import (
    imposed_accelerations,
    imposed_velocities,
    loads,
    potentials,
    tangent_symbols,
)
from kinolab.dynamics.language.quantities import Change, FrameQuantity, written
from kinolab.dynamics.language.quasi_velocities import QuasiVelocity, QuasiVelocitySymbol
from kinolab.dynamics.symbols.expressions import exact
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
    parts = [load for _, load in loads(system)]
    velocities = tangent_symbols(system)
    names = [symbol.name for symbol in velocities]
    kinetic = kinetic_energy(system)
    states = [*(v.velocity for v in quasi), *(velocities[names.index(name)] for name in rates)]
    values = system.parameter_values
    return MultiplierForm(
        kinetic=None if kinetic == 0 else place(kinetic),
        potential=place(sympy.Add(weight_energy(system), *potentials(system), evaluate=False)),
        position_loads=tuple(
            (place(load.magnitude), place(load.velocity.position))
            for load in parts
            if isinstance(load.velocity, Change)
        ),
        velocity_loads=tuple(
            (place(load.magnitude), place(written(load.velocity)))
            for load in parts
            if not isinstance(load.velocity, Change)
        ),
        imposed=tuple(
            VelocityRow(place(velocity), place(equals), place(change))
            for velocity, equals, change in (
                *((constraint.velocity, 0, 0) for constraint in system.constraints),
                *((e.velocity, e.symbol, e.change) for e in imposed_velocities(system)),
            )
        ),
        driven=tuple(
            (names.index(f"{coordinate}_dot"), place(symbol))
            for coordinate, symbol in imposed_accelerations(system).items()
        ),
        states=tuple(map(place, states)),
        further=tuple(place(entry.derivative) for entry in system.states),
        instructions=tuple(place.instructions),
        coordinates=tuple(tuple(e.name for e in c.entries) for c in system.coordinates),
        velocities=tuple(names),
        inputs=tuple(entry.name for entry in system.inputs),
        further_names=tuple(entry.name for entry in system.states),
        parameters=tuple((p.name, values[p.name]) for p in system.parameters),
    )


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
            self.instructions.append(self._instruction(stated))  # after those of its parts
            self._places[stated] = len(self.instructions) - 1
        return self._places[stated]

    def _instruction(self, expression: sympy.Expr) -> Instruction:
        if expression.is_number:
            return Instruction("number", number=float(expression))
        if isinstance(expression, Change):
            return Instruction("change", (self(expression.position),))
        if isinstance(expression, FrameQuantity):
            return Instruction("add", (self(expression.formula),))
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
