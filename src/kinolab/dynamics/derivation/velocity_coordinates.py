"""Velocity coordinates (generalised speeds): independent velocities, and all others from them.

Constraints, rate inputs and speeds that are states are rows A(q) nu = b with b zero, an input or a
state. A fixed choice of independent velocities v determines the others: nu = S(q) v + U(q) b. Some
of v may be quasi-velocities, which are rows with the quasi-velocity on the right.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy

from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node
from kinolab.dynamics.derivation.regularity import VelocityChoice
from kinolab.dynamics.derivation.sampled_states import feasible_values
from kinolab.dynamics.derivation.symbol_table import SOME_VELOCITY, SymbolTable
from kinolab.dynamics.derivation.symbolic_solve import Guards, solve_square
from kinolab.dynamics.derivation.velocity_choice import choose_velocities
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.quasi_velocities import QuasiVelocity
from kinolab.errors import InputError, Mistake


@dataclass(frozen=True)
class ConstraintRow:
    """One linear condition on the velocities: covector . nu = value.

    Attributes:
        name: Of the constraint, input or state.
        covector: Coefficient of each velocity.
        value: Zero for a constraint, the input of a rate input, the state of a speed, the value of
            a quasi-velocity.
        bias: d/dt(covector) . nu, the acceleration-free part of the derivative, in the velocity
            variables.
    """

    name: str
    covector: tuple[Node, ...]
    value: Node
    bias: Node


@dataclass(frozen=True)
class VelocityCoordinates:
    """All velocities as functions of the independent ones.

    Attributes:
        rows: The conditions; without redundant ones, but where multipliers follow from them.
        redundant: Names of redundant constraints.
        quasi: The quasi-velocities that are states, before the rates that are.
        quasi_rows: Their definitions.
        dependent: Indices of the velocities determined by all rows.
        independent: Indices of the velocities that are states.
        states: The variables of the independent velocities v.
        driven: Positions in v whose acceleration is an input, with its node.
        directions: Columns of S, one per independent velocity.
        input_directions: Columns of U, by the node of the input or state.
        velocities: nu = S v + U b.
        accelerations: d/dt nu for zero accelerations of v.
    """

    rows: tuple[ConstraintRow, ...]
    redundant: tuple[str, ...]
    quasi: tuple[QuasiVelocity, ...]
    quasi_rows: tuple[ConstraintRow, ...]
    dependent: tuple[int, ...]
    independent: tuple[int, ...]
    states: tuple[Node, ...]
    driven: dict[int, Node]
    directions: tuple[tuple[Node, ...], ...]
    input_directions: dict[Node, tuple[Node, ...]]
    velocities: tuple[Node, ...]
    accelerations: tuple[Node, ...]

    @property
    def defining(self) -> tuple[ConstraintRow, ...]:
        """All rows, whose block of dependent velocities must be regular."""
        return (*self.rows, *self.quasi_rows)


def constraint_rows(binding: SymbolTable) -> list[ConstraintRow]:
    """Return the rows of all constraints, redundant ones included.

    Raises:
        InputError: If one is not linear in the rates, does not vanish at rest, or is vacuous.
    """
    return [
        _row(binding, f"constraint {c.name!r}", c.name, c.velocity, binding.tape.zero)
        for c in binding.system.constraints
    ]


def velocity_coordinates(binding: SymbolTable, guards: Guards) -> VelocityCoordinates:
    """Choose the independent velocities and solve for all others; with multipliers all are such."""
    rows, redundant, choice = _chosen(binding)
    if binding.by_multipliers:
        return replace(unconstrained_coordinates(binding), rows=tuple(rows), redundant=redundant)
    return _solve(binding, guards, rows, redundant, choice)


def chosen_quasi_velocities(system: Mechanism) -> tuple[QuasiVelocity, ...]:
    """Return the quasi-velocities among a machine's independent velocities, mostly none.

    Raises:
        InputError: As ``derive``, for what concerns constraints and velocities.
    """
    if system.velocities == "all":
        return ()
    return _chosen(SymbolTable.of(system))[-1].quasi


def _chosen(
    binding: SymbolTable,
) -> tuple[list[ConstraintRow], tuple[str, ...], VelocityChoice]:
    """Return what constraints, inputs and speeds demand of velocities, and which are chosen.

    In between, the names of redundant constraints.
    """
    every, states = constraint_rows(binding), list(feasible_values(binding))
    rows, redundant = _independent(every, _samples(binding, every, states))
    if binding.by_multipliers:
        return every, redundant, VelocityChoice(())
    rows += [
        _row(binding, entry.where, str(entry.symbol), entry.velocity, binding.lower(entry.symbol))
        for entry in binding.imposed
    ]
    samples = _samples(binding, rows, states) if rows else np.empty((1, 0, len(binding.tangent)))
    covectors = [row.covector for row in rows]
    return rows, redundant, choose_velocities(binding, covectors, samples, redundant)


def unconstrained_coordinates(binding: SymbolTable) -> VelocityCoordinates:
    """Return the velocity coordinates in which every velocity is independent."""
    return replace(_solve(binding, Guards(), (), (), VelocityChoice(())), driven={})


def _row(
    binding: SymbolTable, where: str, name: str, velocity: sympy.Expr, value: Node
) -> ConstraintRow:
    tape = binding.tape
    node, covector = binding.linear_slopes(velocity, lambda: where)
    flow = binding.flow()
    at_rest = tape.substitute([node], dict.fromkeys(binding.tangent, tape.zero))[0]
    if at_rest != tape.zero:
        what = "it does not vanish when the machine rests."
        raise InputError([Mistake(where, what, SOME_VELOCITY)])
    if all(entry == tape.zero for entry in covector):
        raise InputError([Mistake(where, "no rate occurs in it.", SOME_VELOCITY)])
    (bias,) = tape.derivative([node], flow)
    return ConstraintRow(name, covector, value, bias)


def independent_rows(
    binding: SymbolTable, rows: list[ConstraintRow]
) -> tuple[list[ConstraintRow], tuple[str, ...]]:
    """Drop constraints that depend linearly on previous ones at every sampled state."""
    return _independent(rows, _samples(binding, rows, feasible_values(binding)))


def _independent(
    rows: list[ConstraintRow], samples: np.ndarray
) -> tuple[list[ConstraintRow], tuple[str, ...]]:
    chosen: list[int] = []
    for k in range(len(rows)):
        trial = samples[:, [*chosen, k], :]
        scale = np.linalg.norm(trial, axis=(1, 2), ord=None)
        ranks = [np.linalg.matrix_rank(m, tol=1e-9 * s) for m, s in zip(trial, scale, strict=True)]
        if max(ranks, default=1) > len(chosen):
            chosen.append(k)
    redundant = tuple(row.name for k, row in enumerate(rows) if k not in chosen)
    return [rows[k] for k in chosen], redundant


def _samples(
    binding: SymbolTable, rows: Sequence[ConstraintRow], states: Iterable[Mapping[str, float]]
) -> np.ndarray:
    """Evaluate the covectors at states; shape (samples, rows, velocities)."""
    flat = [entry for row in rows for entry in row.covector]
    shape = (len(rows), len(binding.tangent))
    found = []
    for values in states:
        try:
            found.append(np.reshape(binding.tape.evaluate(flat, values), shape))
        except (ArithmeticError, ValueError):
            continue  # expressions, and thus the machine, are undefined there
    if not found:
        what = "its constraints hold at none of the sampled states."
        where = f"system {binding.system.name!r}"
        raise InputError([Mistake(where, what, "Check them and the limits.")])
    return np.array(found)


def _solve(
    binding: SymbolTable,
    guards: Guards,
    rows: Sequence[ConstraintRow],
    redundant: tuple[str, ...],
    choice: VelocityChoice,
) -> VelocityCoordinates:
    tape, size, dependent = binding.tape, len(binding.tangent), choice.dependent
    independent = tuple(i for i in range(size) if i not in dependent)
    quasi_rows = [
        _row(binding, f"velocity {v.name!r}", v.name, v.velocity, tape.variable(v.name))
        for v in choice.quasi
    ]
    defining = [*rows, *quasi_rows]
    block = [[row.covector[i] for i in dependent] for row in defining]
    inputs = list(dict.fromkeys(row.value for row in rows if row.value != tape.zero))
    columns = [_right_side(tape, defining, row.value) for row in quasi_rows]
    columns += [[tape.neg(row.covector[i]) for row in defining] for i in independent]
    columns += [_right_side(tape, defining, entry) for entry in inputs]
    shares = solve_square(tape, block, columns, guards, [row.covector for row in defining])
    units: list[dict[int, Node]] = [{} for _ in quasi_rows]
    units += [{i: tape.one} for i in independent] + [{} for _ in inputs]
    spread = [
        _spread(binding, unit | dict(zip(dependent, fraction, strict=True)))
        for unit, fraction in zip(units, shares, strict=True)
    ]
    states = (*(row.value for row in quasi_rows), *(binding.tangent[i] for i in independent))
    velocities = tuple(
        tape.sum(
            tape.mul(column[k], value)
            for column, value in zip(spread, (*states, *inputs), strict=True)
        )
        for k in range(size)
    )
    biases = tape.substitute([row.bias for row in defining], binding.at(velocities))
    (drift,) = solve_square(tape, block, [[tape.neg(bias) for bias in biases]], Guards())
    return VelocityCoordinates(
        rows=tuple(rows),
        redundant=redundant,
        quasi=choice.quasi,
        quasi_rows=tuple(quasi_rows),
        dependent=dependent,
        independent=independent,
        states=states,
        driven={
            k: binding.driven[i]
            for k, i in enumerate(independent, start=len(quasi_rows))
            if i in binding.driven
        },
        directions=tuple(spread[: len(states)]),
        input_directions=dict(zip(inputs, spread[len(states) :], strict=True)),
        velocities=velocities,
        accelerations=_spread(binding, dict(zip(dependent, drift, strict=True))),
    )


def _right_side(tape: ExpressionGraph, rows: Sequence[ConstraintRow], value: Node) -> list[Node]:
    """Return the coefficient of a value on the right of each row."""
    return [tape.one if row.value == value else tape.zero for row in rows]


def _spread(binding: SymbolTable, entries: dict[int, Node]) -> tuple[Node, ...]:
    """Return a vector that is zero except at the given indices."""
    return tuple(entries.get(i, binding.tape.zero) for i in range(len(binding.tangent)))


def combine(
    binding: SymbolTable, columns: Iterable[Sequence[Node]], values: Iterable[Node]
) -> list[Node]:
    """Return the linear combination of columns, an entry per velocity."""
    tape = binding.tape
    total = [tape.zero] * len(binding.tangent)
    for column, value in zip(columns, values, strict=True):
        total = [tape.add(t, tape.mul(c, value)) for t, c in zip(total, column, strict=True)]
    return total
