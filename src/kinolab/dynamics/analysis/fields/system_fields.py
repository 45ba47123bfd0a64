"""Vector fields of a machine, and the distribution of velocities its constraints allow."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from kinolab.arguments import checked
from kinolab.dynamics.analysis.fields.vector_fields import VectorFields, first
from kinolab.dynamics.derivation.derivation import Derivation, derive
from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.sampled_states import feasible_values
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.derivation.symbolic_solve import Guards
from kinolab.dynamics.derivation.velocity_coordinates import (
    VelocityCoordinates,
    constraint_rows,
    velocity_coordinates,
)
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import (
    configuration_symbols,
    state_symbols,
    tangent_symbols,
)
from kinolab.errors import InputError, Mistake


@checked
def vector_fields(system: Mechanism) -> VectorFields:
    """Return the drift and input fields of a machine, x_dot = f(x) + sum of u_i g_i(x).

    The state is that of the compiled model: x = q for a kinematic machine, (q, v) for a dynamic
    one, auxiliary states last. Where an input does not enter linearly, all inputs become states
    whose rates are the inputs, which preserves accessibility.

    Args:
        system: The machine.

    Raises:
        InputError: If the machine cannot be derived.

    Source: Nijmeijer, van der Schaft, Nonlinear Dynamical Control Systems, 1990, chapter 6 (inputs
    that become states).
    """
    derivation = derive(system)
    binding, derivative = derivation.binding, derivation.derivative
    tape, inputs = binding.tape, binding.inputs
    still = tape.substitute(derivative, dict.fromkeys(inputs, tape.zero))
    slopes = [tuple(tape.derivative(derivative, {node: tape.one})) for node in inputs]
    symbols = state_symbols(system, [v.symbol for v in derivation.quasi], derivation.independent)
    whole = VectorFields(
        symbols=symbols,
        tape=tape,
        state=derivation.state,
        drift=tuple(still),
        inputs={e.name: slope for e, slope in zip(system.inputs, slopes, strict=True)},
        values=system.parameter_values,
        dimension=len(symbols) - normal_count(system, derivation.redundant),
        constants=system.parameters,
        points=first(_samples(system, derivation)),
        held=bool(system.closures),
    )
    moving = frozenset(inputs)
    if any(tape.depends_on(node) & moving for slope in slopes for node in slope):
        return _prolonged(system, whole, derivative, inputs)
    return whole


@checked
def allowed_motions(system: Mechanism) -> VectorFields:
    """Return fields on the configuration space that span the allowed velocities.

    The kernel of w(q): one field per independent velocity, named after it. Masses and forces play
    no part.

    Args:
        system: The machine.

    Raises:
        InputError: If the constraints depend on inputs or auxiliary states, or no fixed choice of
            independent velocities serves.
    """
    if system.velocities == "all":
        system = system.changed(velocities=None)  # kinolab chooses independent ones
    binding = SymbolTable.of(system)
    chart = velocity_coordinates(binding, Guards())
    return VectorFields(
        symbols=configuration_symbols(system),
        tape=binding.tape,
        state=binding.configuration,
        drift=(binding.tape.zero,) * len(binding.configuration),
        inputs=_motions(binding, chart),
        values=system.parameter_values,
        dimension=len(binding.tangent),
        constants=system.parameters,
        points=first(feasible_values(binding)),
        held=bool(system.closures),
    )


def normal_count(system: Mechanism, redundant: Sequence[str]) -> int:
    """Return how many equations unit quaternions and constraints impose on a state."""
    of_states = system.constraints if system.velocities == "all" else ()
    kept = sum(c.name not in redundant for c in (*system.closures, *of_states))
    return sum(len(c.entries) - len(c.rates) for c in system.coordinates) + kept


def _samples(system: Mechanism, derivation: Derivation) -> Iterator[dict[str, float]]:
    """Yield consistent states, velocity constraints included where all rates are states."""
    binding = derivation.binding
    rows = constraint_rows(binding) if system.velocities == "all" else []
    flat = [entry for row in rows for entry in row.covector]
    names = [symbol.name for symbol in tangent_symbols(system)]
    for values in feasible_values(binding):
        w = np.reshape(binding.tape.evaluate(flat, values), (len(rows), len(names)))
        velocity = np.array([values[name] for name in names])
        velocity -= np.linalg.pinv(w) @ w @ velocity
        values |= dict(zip(names, map(float, velocity), strict=True))
        chosen = [binding.lower(v.velocity) for v in derivation.quasi]
        found = binding.tape.evaluate(chosen, values)
        yield values | {v.name: x for v, x in zip(derivation.quasi, found, strict=True)}


def _prolonged(
    system: Mechanism, whole: VectorFields, derivative: Sequence[Node], inputs: Sequence[Node]
) -> VectorFields:
    """Prolong: inputs become states, and their rates the inputs."""
    tape, count = whole.tape, len(whole.symbols)
    unit = {
        f"{entry.name}_dot": tuple(
            tape.one if k == count + i else tape.zero for k in range(count + len(inputs))
        )
        for i, entry in enumerate(system.inputs)
    }
    return replace(
        whole,
        symbols=(*whole.symbols, *(entry.symbol for entry in system.inputs)),
        state=(*whole.state, *inputs),
        drift=(*derivative, *(tape.zero for _ in inputs)),
        inputs=unit,
        dimension=whole.dimension + len(inputs),
        points=tuple({**point, **_within_limits(system, point)} for point in whole.points),
        prolonged=True,
    )


def _within_limits(system: Mechanism, point: Mapping[str, float]) -> dict[str, float]:
    """Move sampled inputs well between their limits: a thrust must not be negative."""
    moved = {}
    for entry in system.inputs:
        lower, upper = bounds_of(entry)
        fraction = 0.5 + 0.25 * math.tanh(point[entry.name])
        moved[entry.name] = lower + fraction * (upper - lower)
    return moved


def _motions(binding: SymbolTable, chart: VelocityCoordinates) -> dict[str, tuple[Node, ...]]:
    """Return the motions of velocity coordinates as fields on configurations, by name."""
    columns = dict(zip(chart.states, chart.directions, strict=True)) | chart.input_directions
    moves = {binding.tape.operations[n].label: binding.flow(d) for n, d in columns.items()}
    found = {
        name: tuple(move[node] for node in binding.configuration) for name, move in moves.items()
    }
    allowed = frozenset((*binding.configuration, *binding.parameters))
    for name, components in found.items():
        if any(binding.tape.depends_on(node) - allowed for node in components):
            what = "its constraints depend on inputs or on more than the configuration."
            where = f"system {binding.system.name!r}"
            raise InputError([Mistake(where, what, f"See {name}.")])
    return found
