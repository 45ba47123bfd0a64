"""Velocity coordinates (generalised speeds): independent velocities, and all others from them.

Constraints, rate inputs and speeds that are states are rows A(q) nu = b with b zero, an input or a
state. A fixed choice of independent velocities v determines the others: nu = S(q) v + U(q) b.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np
import sympy

from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.symbol_table import SymbolTable, sampled_values
from kinolab.dynamics.derivation.symbolic_solve import Guards, solve_square
from kinolab.dynamics.language.constraints import Constraint, PositionConstraint
from kinolab.dynamics.language.expressions import exact
from kinolab.dynamics.language.frames import time_derivative
from kinolab.dynamics.language.inputs import Drive, Rate
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import tangent_symbols
from kinolab.dynamics.language.symbols import Coordinate
from kinolab.errors import InputError, Mistake

MIN_PIVOT = 1e-6  # smallest singular value of a usable choice, relative to the rows' norm
NEWTON_STEPS = 50  # towards a configuration that satisfies the loop closure
CLOSURE_TOLERANCE = 1e-10  # [m] or [rad], of such a configuration
MAX_CHOICES = 5000  # above which the choice is greedy instead of optimal


@dataclass(frozen=True)
class ConstraintRow:
    """One linear condition on the velocities: covector . nu = value.

    Attributes:
        name: Of the constraint, input or state.
        covector: Coefficient of each velocity.
        value: Zero for a constraint, the input of a rate input, the state of a speed.
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
        rows: The conditions without redundant ones.
        redundant: Names of redundant constraints.
        dependent: Indices of the velocities determined by the rows.
        independent: Indices of the velocities that are states.
        driven: Positions in ``independent`` whose acceleration is an input, with its node.
        directions: Columns of S, one per independent velocity.
        input_directions: Columns of U, by the node of the input or state.
        velocities: nu = S v + U b.
        accelerations: d/dt nu for zero accelerations of v.
    """

    rows: tuple[ConstraintRow, ...]
    redundant: tuple[str, ...]
    dependent: tuple[int, ...]
    independent: tuple[int, ...]
    driven: dict[int, Node]
    directions: tuple[tuple[Node, ...], ...]
    input_directions: dict[Node, tuple[Node, ...]]
    velocities: tuple[Node, ...]
    accelerations: tuple[Node, ...]


def velocity_of(constraint: Constraint) -> sympy.Expr:
    """Return the velocity that a constraint sets to zero."""
    if isinstance(constraint, PositionConstraint):
        return time_derivative(constraint.position)
    return constraint.velocity


def constraint_rows(system: Mechanism, binding: SymbolTable) -> list[ConstraintRow]:
    """Return the rows of all constraints, redundant ones included.

    Raises:
        InputError: If one is not linear in the rates, does not vanish at rest, or is vacuous.
    """
    return [
        _row(binding, f"constraint {c.name!r}", c.name, velocity_of(c), binding.tape.zero)
        for c in system.constraints
    ]


def velocity_coordinates(
    system: Mechanism, binding: SymbolTable, guards: Guards
) -> VelocityCoordinates:
    """Choose the independent velocities and solve for all others."""
    rows, redundant = independent_rows(system, binding, constraint_rows(system, binding))
    rows += [
        _row(binding, f"input {i.name!r}", i.name, i.velocity, binding.lower(i.symbol))
        for i in system.inputs
        if isinstance(i, Rate)
    ]
    rows += [
        _row(binding, f"state {s.name!r}", s.name, s.velocity, binding.lower(s.symbol))
        for s in system.states
        if s.velocity is not None
    ]
    dependent = _choose(system, binding, rows)
    independent = tuple(i for i in range(len(binding.tangent)) if i not in dependent)
    return _solve(system, binding, guards, rows, redundant, dependent, independent)


def condition_number(system: Mechanism, values: Mapping[str, float]) -> float:
    """Return the condition number of the solve for the dependent velocities at a state.

    Args:
        system: The machine.
        values: Of the configuration and the parameters, by name.
    """
    binding = SymbolTable.of(system)
    chart = velocity_coordinates(system, binding, Guards())
    block = [[row.covector[i] for i in chart.dependent] for row in chart.rows]
    flat = [entry for row in block for entry in row]
    matrix = np.reshape(binding.tape.evaluate(flat, dict(values)), (len(block), -1))
    whole = [entry for row in chart.rows for entry in row.covector]
    size = np.linalg.norm(binding.tape.evaluate(whole, dict(values)))
    smallest = np.linalg.svd(matrix, compute_uv=False)[-1]
    return float(size / max(smallest, 1e-300))


def unconstrained_coordinates(binding: SymbolTable) -> VelocityCoordinates:
    """Return the velocity coordinates in which every velocity is independent."""
    tape, size = binding.tape, len(binding.tangent)
    unit = [[tape.one if i == j else tape.zero for i in range(size)] for j in range(size)]
    return VelocityCoordinates(
        rows=(),
        redundant=(),
        dependent=(),
        independent=tuple(range(size)),
        driven={},
        directions=tuple(map(tuple, unit)),
        input_directions={},
        velocities=binding.tangent,
        accelerations=(tape.zero,) * size,
    )


def _row(
    binding: SymbolTable, where: str, name: str, velocity: sympy.Expr, value: Node
) -> ConstraintRow:
    tape = binding.tape
    node, covector = _slopes(binding, velocity)
    moving = frozenset(binding.tangent)
    if any(tape.depends_on(entry) & moving for entry in covector):
        node, covector = _slopes(binding, sympy.expand(velocity))
    if any(tape.depends_on(entry) & moving for entry in covector):
        raise InputError([Mistake(where, "it is not linear in the rates.")])
    at_rest = tape.substitute([node], dict.fromkeys(binding.tangent, tape.zero))[0]
    if at_rest != tape.zero:
        remedy = "State a velocity, such as V.y."
        raise InputError([Mistake(where, "it does not vanish when the machine rests.", remedy)])
    if all(entry == tape.zero for entry in covector):
        raise InputError([Mistake(where, "it never bites: no rate occurs in it.")])
    (bias,) = tape.derivative([node], binding.flow())
    return ConstraintRow(name, covector, value, bias)


def _slopes(binding: SymbolTable, velocity: sympy.Expr) -> tuple[Node, tuple[Node, ...]]:
    """Return a velocity's node and its derivative by each of the machine's velocities."""
    tape, node = binding.tape, binding.lower(exact(velocity))
    return node, tuple(tape.derivative([node], {v: tape.one})[0] for v in binding.tangent)


def independent_rows(
    system: Mechanism, binding: SymbolTable, rows: list[ConstraintRow]
) -> tuple[list[ConstraintRow], tuple[str, ...]]:
    """Drop constraints that depend linearly on previous ones at every sampled state."""
    kept: list[ConstraintRow] = []
    redundant: list[str] = []
    samples = _samples(system, binding, rows)
    chosen: list[int] = []
    for k, row in enumerate(rows):
        trial = samples[:, [*chosen, k], :]
        scale = np.linalg.norm(trial, axis=(1, 2), ord=None)
        ranks = [np.linalg.matrix_rank(m, tol=1e-9 * s) for m, s in zip(trial, scale, strict=True)]
        if max(ranks, default=1) > len(chosen):
            chosen.append(k)
            kept.append(row)
        else:
            redundant.append(row.name)
    return kept, tuple(redundant)


def _samples(system: Mechanism, binding: SymbolTable, rows: Sequence[ConstraintRow]) -> np.ndarray:
    """Evaluate the covectors at random states; shape (samples, rows, velocities)."""
    flat = [entry for row in rows for entry in row.covector]
    shape = (len(rows), len(binding.tangent))
    found = []
    for values in feasible_values(system, binding):
        try:
            found.append(np.reshape(binding.tape.evaluate(flat, values), shape))
        except (ArithmeticError, ValueError):
            continue  # expressions, and thus the machine, are undefined there
    if not found:
        what = "its constraints hold at none of the sampled states."
        raise InputError([Mistake(f"system {system.name!r}", what, "Check them and the limits.")])
    return np.array(found)


def feasible_values(system: Mechanism, binding: SymbolTable) -> Iterator[dict[str, float]]:
    """Yield sampled values of all symbols, projected onto the position constraints."""
    gaps = [
        binding.lower(c.position) for c in system.constraints if isinstance(c, PositionConstraint)
    ]
    slopes = [node for gap in gaps for node in _gradient(binding, gap)]
    names = [binding.tape.operations[node].label for node in binding.configuration]
    for values in sampled_values(system):
        try:
            if _close(binding, gaps, slopes, names, values):
                yield values
        except (ArithmeticError, ValueError):
            continue


def _gradient(binding: SymbolTable, node: Node) -> list[Node]:
    tape = binding.tape
    return [tape.derivative([node], {q: tape.one})[0] for q in binding.configuration]


def _close(
    binding: SymbolTable,
    gaps: Sequence[Node],
    slopes: Sequence[Node],
    names: Sequence[str],
    values: dict[str, float],
) -> bool:
    """Project a configuration onto the constraints by least-norm Newton steps."""
    if not gaps:
        return True
    for _ in range(NEWTON_STEPS):
        gap = np.array(binding.tape.evaluate(gaps, values))
        if np.abs(gap).max() < CLOSURE_TOLERANCE:
            return True
        matrix = np.reshape(binding.tape.evaluate(slopes, values), (len(gaps), len(names)))
        move = np.linalg.lstsq(matrix, gap, rcond=None)[0]
        for name, change in zip(names, move, strict=True):
            values[name] -= float(change)
    return False


def _choose(system: Mechanism, binding: SymbolTable, rows: list[ConstraintRow]) -> tuple[int, ...]:
    """Choose the dependent velocities with the best conditioning at the worst sampled state.

    On ties, coordinates created first become dependent, so that later ones remain states.
    """
    named = _named(system)
    if not rows:
        if named is not None and len(named) != len(binding.tangent):
            what = f"{len(named)} velocities are named; without constraints all are independent."
            raise InputError([Mistake(f"system {system.name!r}", what, "Leave velocities out.")])
        return ()
    samples = _samples(system, binding, rows)
    candidates = _candidates(system, samples, named)
    sizes = np.linalg.norm(samples, axis=(1, 2), ord=2)
    margins = [_margins(samples[:, :, list(dependent)], sizes) for dependent in candidates]
    best = max(
        range(len(candidates)),
        key=lambda k: (
            round(float(margins[k].min()), 9),
            round(float(np.median(margins[k])), 9),
            -k,
        ),
    )
    if np.median(margins[best]) < MIN_PIVOT:
        what = "no fixed choice of independent velocities works at all sampled states."
        remedy = 'Name them with velocities=[…], or use velocities="all" for multipliers.'
        raise InputError([Mistake(f"system {system.name!r}", what, remedy)])
    return candidates[best]


def _candidates(
    system: Mechanism, samples: np.ndarray, named: list[int] | None
) -> list[tuple[int, ...]]:
    count, size = samples.shape[1], samples.shape[2]
    if named is not None:
        if len(named) != size - count:
            what = f"{len(named)} velocities are named; {size - count} are independent."
            raise InputError([Mistake(f"system {system.name!r}", what)])
        return [tuple(i for i in range(size) if i not in named)]
    free = [i for i in range(size) if i not in _driven(system)]
    if count > len(free):
        what = f"{count} constraints, rate inputs and speeds act on {len(free)} velocities."
        raise InputError([Mistake(f"system {system.name!r}", what, "Leave some out.")])
    if comb(len(free), count) <= MAX_CHOICES:
        return list(combinations(free, count))
    return [_greedy(samples[k][:, free], free, count) for k in range(len(samples))]


def _named(system: Mechanism) -> list[int] | None:
    """Return the velocities chosen by the author, three for an attitude."""
    if system.velocities is None or isinstance(system.velocities, str):
        return None
    symbols = [s.name for s in tangent_symbols(system)]
    names = [
        name
        for c in system.velocities
        for name in (
            [f"{c.name}_dot"] if isinstance(c, Coordinate) else [s.name for s in c.turn_rate]
        )
    ]
    return [symbols.index(name) for name in names]


def _greedy(matrix: np.ndarray, free: Sequence[int], count: int) -> tuple[int, ...]:
    """Choose columns by pivoted QR at one state."""
    from scipy.linalg import qr

    _, _, order = qr(matrix, pivoting=True)
    return tuple(sorted(free[k] for k in order[:count]))


def _driven(system: Mechanism) -> dict[int, Drive]:
    symbols = [symbol.name for symbol in tangent_symbols(system)]
    return {
        symbols.index(f"{entry.on.name}_dot"): entry
        for entry in system.inputs
        if isinstance(entry, Drive)
    }


def _margins(blocks: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Return the smallest singular values relative to the rows' norms, shape (samples,).

    Args:
        blocks: Square matrices, shape (samples, n, n).
        sizes: Largest singular value of the full rows, shape (samples,).
    """
    smallest = np.linalg.svd(blocks, compute_uv=False)[:, -1]
    shares: np.ndarray = smallest / np.maximum(sizes, 1e-300)
    return shares


def _solve(
    system: Mechanism,
    binding: SymbolTable,
    guards: Guards,
    rows: Sequence[ConstraintRow],
    redundant: tuple[str, ...],
    dependent: tuple[int, ...],
    independent: tuple[int, ...],
) -> VelocityCoordinates:
    tape, size = binding.tape, len(binding.tangent)
    block = [[row.covector[i] for i in dependent] for row in rows]
    inputs = list(dict.fromkeys(row.value for row in rows if row.value != tape.zero))
    columns = [[tape.neg(row.covector[i]) for row in rows] for i in independent]
    columns += [[tape.one if row.value == entry else tape.zero for row in rows] for entry in inputs]
    shares = solve_square(tape, block, columns, guards, [row.covector for row in rows])
    units = [{i: tape.one} for i in independent] + [{} for _ in inputs]
    spread = [
        _spread(binding, unit | dict(zip(dependent, fraction, strict=True)))
        for unit, fraction in zip(units, shares, strict=True)
    ]
    directions, pushed = spread[: len(independent)], spread[len(independent) :]
    values = [*(binding.tangent[i] for i in independent), *inputs]
    velocities = tuple(
        tape.sum(tape.mul(column[k], value) for column, value in zip(spread, values, strict=True))
        for k in range(size)
    )
    biases = tape.substitute([row.bias for row in rows], binding.at(velocities))
    (drift,) = solve_square(tape, block, [[tape.neg(bias) for bias in biases]], Guards())
    driven = _driven(system)
    return VelocityCoordinates(
        rows=tuple(rows),
        redundant=redundant,
        dependent=dependent,
        independent=independent,
        driven={
            k: binding.lower(driven[i].symbol) for k, i in enumerate(independent) if i in driven
        },
        directions=tuple(directions),
        input_directions=dict(zip(inputs, pushed, strict=True)),
        velocities=velocities,
        accelerations=_spread(binding, dict(zip(dependent, drift, strict=True))),
    )


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
