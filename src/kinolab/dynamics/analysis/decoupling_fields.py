"""Decoupling vector fields: directions that a machine with too few inputs can follow at any speed.

A field V on the configurations is decoupling if it and the covariant derivative of itself along
itself lie in the span of the inputs, Y. The machine then follows the integral curves of V under
every time scaling, so that paths made of such curves, with stops in between, can be carried out.

Source: Bullo, Lynch, Kinematic controllability for decoupled trajectory planning in underactuated
mechanical systems, IEEE Trans. Robotics and Automation 17(4), 2001; Bullo, Lewis, Geometric Control
of Mechanical Systems, 2005, section 8.3.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import combinations, combinations_with_replacement, islice

import numpy as np
import sympy

from kinolab.arguments import checked
from kinolab.dynamics.analysis.fields.system_fields import vector_fields
from kinolab.dynamics.analysis.fields.to_sympy import to_sympy
from kinolab.dynamics.analysis.fields.vector_fields import VectorFields
from kinolab.dynamics.derivation.derivation import Derivation, derive
from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.sampled_states import feasible_values
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.derivation.symbolic_solve import Guards, solve_square
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import imposed_velocities, tangent_symbols
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array

SAME = 1e-8  # of the terms of a sum: it is zero up to rounding
FULL_RANK = 1e-6  # of the largest singular value of the inputs' effect


@checked
@dataclass(frozen=True, eq=False)
class DecouplingFields:
    """Decoupling vector fields of a machine.

    Attributes:
        velocities: Independent velocities (nv,) along each field, by the field's name; nodes.
        moved: Names of the coordinates that each field changes.
        fields: The same as fields on the configurations, q_dot (nq,), without drift.
        velocity_symbols: The independent velocities, (nv,).
        damped: Names of the fields along which friction acts where no input does.
        together: Whether every combination of the inputs' effects is decoupling.
        exhaustive: Whether there are no others, for certain: it is so with two inputs.
    """

    velocities: Mapping[str, tuple[Node, ...]]
    moved: Mapping[str, tuple[str, ...]]
    fields: VectorFields
    velocity_symbols: tuple[sympy.Expr, ...]
    damped: tuple[str, ...]
    together: bool
    exhaustive: bool

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the fields: of the velocities that they set, which fix all others."""
        return tuple(self.velocities)

    def size(self, name: str) -> int:
        """Return the number of operations of a field's expressions, common ones counted once."""
        return len(self.fields.tape.needed(self.velocities[name]))

    def expressions(self, name: str) -> tuple[sympy.Expr, ...]:
        """Return the independent velocities (nv,) along a field, in the author's symbols."""
        fields = self.fields
        named = {symbol.name: symbol for symbol in (*fields.symbols, *fields.constants)}
        return tuple(to_sympy(fields.tape, self.velocities[name], named))


@checked
def decoupling_fields(system: Mechanism) -> DecouplingFields:
    """Return the decoupling vector fields of a machine that combine at most two inputs' effects.

    Friction is left out, and named where it would keep the machine from following a field.

    Args:
        system: The machine.

    Raises:
        InputError: If the notion does not apply to the machine, with the reason, or if the machine
            cannot be derived. A machine to which it applies may have no such fields.
    """
    reason = _outside_the_theory(system)
    if reason:
        raise _refusal(system, reason)
    whole, derivation = vector_fields(system), derive(system)
    if whole.prolonged:
        raise _refusal(system, "an input does not enter its equations linearly")
    return _Decoupling(system, derivation, whole).result()


def _outside_the_theory(system: Mechanism) -> str:
    if system.feedback is not None or system.states:
        return "it has feedback or states of its own"
    if imposed_velocities(system):
        return "its inputs are velocities already"
    if system.velocities == "all":
        return "all of its rates are states"
    return ""


def _refusal(system: Mechanism, reason: str) -> InputError:
    what = f"it has no decoupling vector fields: {reason}."
    return InputError([Mistake(f"system {system.name!r}", what)])


class _Decoupling:
    """The search for decoupling fields of one machine.

    Velocities in the span of the inputs are v = B b, where b (m,) are m of them, the pivots, and
    the others follow: v_rest = C(q) b. A field V = B b is decoupling if, without inputs, v_rest -
    C v_pivots would not change along it. That is a quadratic form in b for every other velocity:
    the derivatives of b itself drop out.
    """

    def __init__(self, system: Mechanism, derivation: Derivation, whole: VectorFields) -> None:
        self._system, self._whole, self._tape = system, whole, whole.tape
        self._count = len(derivation.quasi) + len(derivation.independent)
        first = len(whole.symbols) - self._count
        self._q, self._v = whole.state[:first], whole.state[first:]
        self._first, self._drift = first, whole.drift[first:]
        rates = tangent_symbols(system)
        self._symbols = (
            *(entry.velocity for entry in derivation.quasi),
            *(rates[i] for i in derivation.independent),
        )
        # 6 random configurations at which an identity is checked
        self._points = list(islice(_configurations(system, whole), 6))
        self._effect = self._effects()
        at_points = self._evaluated([node for row in self._effect for node in row])
        at_points = at_points.reshape(len(self._points), self._count, -1)
        self._require_balance(at_points)
        self._pivots, self._columns = _independent(at_points)
        self._rest = [i for i in range(self._count) if i not in self._pivots]
        # C (rest, pivots): how the other velocities follow the pivots, by the inputs.
        A, columns = self._effect, self._columns
        square = [[A[i][j] for i in self._pivots] for j in columns]  # transposed
        right = [[A[i][j] for j in columns] for i in self._rest]
        self._C = solve_square(self._tape, square, right, Guards()) if right else []
        self._basis = self._bases()[0]
        self._basis = max(self._bases(), key=self._alone)

    def _bases(self) -> tuple[dict[str, tuple[Node, ...]], ...]:
        """Return two bases of the inputs' span as pivots (m,) by name: by velocities, by inputs."""
        tape, count = self._tape, len(self._pivots)
        names = list(self._whole.inputs)
        units = ([tape.one if i == k else tape.zero for i in range(count)] for k in range(count))
        pushed = ([self._effect[i][j] for i in self._pivots] for j in self._columns)
        return (
            {self._name(k): tuple(unit) for k, unit in enumerate(units)},
            {names[j]: tuple(push) for j, push in zip(self._columns, pushed, strict=True)},
        )

    def _alone(self, basis: dict[str, tuple[Node, ...]]) -> int:
        """Count the fields of a basis that are decoupling by themselves."""
        self._basis = basis
        return sum(self._vanishes(self._form(k, k)) for k in range(len(basis)))

    def result(self) -> DecouplingFields:
        directions = self._directions()
        velocities = {name: tuple(self._along(b)) for name, b in directions.items()}
        flows = {name: self._flow(v) for name, v in velocities.items()}
        names = self._whole.names[: self._first]
        moved = {name: self._moved(flow) for name, flow in flows.items()}
        damped = [name for name, v in velocities.items() if not self._undamped(v)]
        fields = VectorFields(
            symbols=self._whole.symbols[: self._first],
            tape=self._tape,
            state=self._q,
            drift=(self._tape.zero,) * self._first,
            inputs=flows,
            values=self._whole.values,
            dimension=self._whole.dimension - self._count,
            constants=self._whole.constants,
            points=tuple({name: point[name] for name in names} for point in self._points[:3]),
            held=self._whole.held,
        )
        count = len(self._pivots)
        pairs = combinations_with_replacement(range(count), 2)
        together = all(self._vanishes(self._form(*pair)) for pair in pairs)
        return DecouplingFields(
            velocities, moved, fields, self._symbols, tuple(damped), together, count < 3
        )

    def _moved(self, flow: Sequence[Node]) -> tuple[str, ...]:
        """Name the coordinates that change at rates (nq,) anywhere."""
        values = np.array([self._tape.evaluate(flow, point) for point in self._points])
        rates = iter((np.abs(values) > SAME).any(axis=0).tolist())
        return tuple(
            coordinate.name
            for coordinate in self._system.coordinates
            if any(list(islice(rates, len(coordinate.entries))))
        )

    # What inputs do

    def _effects(self) -> list[list[Node]]:
        """Return the inputs' effect on velocities (nv, nu); it may depend on the configuration."""
        columns = [slope[self._first :] for slope in self._whole.inputs.values()]
        rows = [list(row) for row in zip(*columns, strict=True)] if columns else []
        if not rows:
            raise _refusal(self._system, "it has no inputs")
        moving = frozenset(self._v)
        if any(self._tape.depends_on(node) & moving for row in rows for node in row):
            raise _refusal(self._system, "what its inputs do depends on its velocity")
        return rows

    def _evaluated(self, nodes: Sequence[Node]) -> Array:
        """Return nodes (n,) at the points, shape (points, n)."""
        return np.array([self._tape.evaluate(nodes, point) for point in self._points])

    def _require_balance(self, effect: Array) -> None:
        """Refuse a machine that gravity or springs move where no input does.

        Args:
            effect: Of the inputs on velocities at the points, shape (points, nv, nu).
        """
        still = dict.fromkeys(self._v, self._tape.zero)
        pulls = self._evaluated(self._tape.substitute(self._drift, still))
        for A, pull in zip(effect, pulls, strict=True):
            held = A @ np.linalg.lstsq(A, pull, rcond=FULL_RANK)[0]
            if np.linalg.norm(pull - held) > FULL_RANK * np.linalg.norm(pull):
                what = "gravity or springs push it where no input does"
                raise _refusal(self._system, what)

    # The quadratic forms

    def _along(self, b: Sequence[Node]) -> list[Node]:
        """Return the velocities v = B b, (nv,)."""
        v = [self._tape.zero] * self._count
        for i, node in zip(self._pivots, b, strict=True):
            v[i] = node
        for i, row in zip(self._rest, self._C, strict=True):
            v[i] = self._tape.dot(row, b)
        return v

    def _flow(self, v: Sequence[Node]) -> tuple[Node, ...]:
        """Return the rates of the coordinates (nq,) at velocities."""
        given = dict(zip(self._v, v, strict=True))
        return tuple(self._tape.substitute(self._whole.drift[: self._first], given))

    def _left_over(self, *parts: Sequence[Node]) -> list[tuple[Node, ...]]:
        """Return a_rest - C a_pivots, which no input changes, as the terms of sums.

        Args:
            parts: Accelerations (nv,) that add up to a.
        """
        tape = self._tape
        return [
            tuple(
                term
                for a in parts
                for term in (
                    a[i],
                    *(tape.neg(tape.mul(c, a[j])) for c, j in zip(row, self._pivots, strict=True)),
                )
            )
            for i, row in zip(self._rest, self._C, strict=True)
        ]

    def _residual(self, b: Sequence[Node]) -> list[tuple[Node, ...]]:
        """Return the terms of the quadratic forms at constant pivots b, one sum for each other."""
        tape, v = self._tape, self._along(b)
        seeds = dict(zip(self._q, self._flow(v), strict=True))
        flat = [node for row in self._C for node in row]
        turned = iter(tape.derivative(flat, seeds))
        changes = [tape.neg(tape.dot([next(turned) for _ in row], b)) for row in self._C]
        forth, back, still = self._unforced(v)
        half = tape.constant(0.5)
        even = ([tape.mul(half, node) for node in part] for part in (forth, back))
        pulled = [tape.neg(node) for node in still]
        left_over = self._left_over(*even, pulled)
        return [(*terms, change) for terms, change in zip(left_over, changes, strict=True)]

    def _unforced(self, v: Sequence[Node]) -> tuple[list[Node], list[Node], list[Node]]:
        """Return accelerations (nv,) without inputs: at velocities, at their opposites, at rest.

        Friction is odd in the velocities; what a motion does to itself is even.
        """
        tape = self._tape
        forth = dict(zip(self._v, v, strict=True))
        back = {node: tape.neg(value) for node, value in forth.items()}
        still = dict.fromkeys(self._v, tape.zero)
        there, again, rest = (tape.substitute(self._drift, given) for given in (forth, back, still))
        return there, again, rest

    def _undamped(self, v: Sequence[Node]) -> bool:
        """Say whether inputs can make up for friction at velocities."""
        forth, back, _ = self._unforced(v)
        return self._vanishes(self._left_over(forth, [self._tape.neg(node) for node in back]))

    def _form(self, k: int, l: int) -> list[tuple[Node, ...]]:  # noqa: E741
        """Return coefficients Q_kl of the forms, as the terms of sums, by polarisation."""
        tape, basis = self._tape, list(self._basis.values())

        def at(*entries: int) -> list[tuple[Node, ...]]:
            chosen = zip(*(basis[i] for i in entries), strict=True)
            return self._residual([tape.sum(parts) for parts in chosen])

        if k == l:
            return at(k)
        half = tape.constant(0.5)
        return [
            (
                *(tape.mul(half, node) for node in both),
                *(tape.mul(half, tape.neg(node)) for node in (*first, *second)),
            )
            for both, first, second in zip(at(k, l), at(k), at(l), strict=True)
        ]

    # Their roots

    def _directions(self) -> dict[str, list[Node]]:
        """Return the pivots b (m,) of all fields that combine at most two of them."""
        tape = self._tape
        found = {
            name: list(b)
            for k, (name, b) in enumerate(self._basis.items())
            if self._vanishes(self._form(k, k))
        }
        named = enumerate(self._basis.items())
        for (k, (one, first)), (l, (other, second)) in combinations(named, 2):  # noqa: E741
            for sign, (x, y) in self._roots(k, l):
                pairs = zip(first, second, strict=True)
                b = [tape.add(tape.mul(x, m), tape.mul(y, n)) for m, n in pairs]
                if self._vanishes(self._residual(b)):
                    found[f"{one} and {other}{sign}"] = b
        return found

    def _roots(self, k: int, l: int) -> Iterator[tuple[str, tuple[Node, Node]]]:  # noqa: E741
        """Yield roots (a_k, a_l), both nonzero, of the first form that is not zero everywhere."""
        tape = self._tape
        forms = zip(self._form(k, k), self._form(k, l), self._form(l, l), strict=True)
        for square, mixed, other in forms:
            a, b, c = (
                tape.zero if self._vanishes([terms]) else tape.sum(terms)
                for terms in (square, mixed, other)
            )
            if a == b == c == tape.zero:
                continue
            if a == tape.zero and c == tape.zero:
                return
            if tape.zero in {a, c}:
                if b != tape.zero:
                    two = tape.mul(tape.constant(2.0), b)
                    only = (tape.neg(c), two) if a == tape.zero else (two, tape.neg(a))
                    yield "", self._unit(only)
                return
            root = tape.sub(tape.mul(b, b), tape.mul(a, c))
            sizes = np.array([self._tape.evaluate([root, tape.mul(b, b)], p) for p in self._points])
            if (sizes[:, 0] < -SAME * np.abs(sizes).max()).any():
                return
            if np.abs(sizes[:, 0]).max() <= SAME * np.abs(sizes).max():
                yield "", self._unit((tape.neg(b), a))
                return
            width = tape.unary("sqrt", root)
            yield " (1)", self._unit((tape.sub(width, b), a))
            yield " (2)", self._unit((tape.sub(tape.neg(width), b), a))
            return

    def _unit(self, root: tuple[Node, Node]) -> tuple[Node, Node]:
        """Scale a direction so that its squares add up to 1; one that never turns is constant."""
        tape = self._tape
        values = np.array([self._tape.evaluate(root, point) for point in self._points])
        with np.errstate(divide="ignore", invalid="ignore"):
            values *= np.sign(values[:, 1:]) / np.linalg.norm(values, axis=1)[:, None]
        if (np.ptp(values, axis=0) <= SAME).all():
            return tape.constant(float(values[0, 0])), tape.constant(float(values[0, 1]))
        size = tape.unary("sqrt", tape.dot(root, root))
        return tape.div(root[0], size), tape.div(root[1], size)

    def _name(self, k: int) -> str:
        label: str = self._tape.operations[self._v[self._pivots[k]]].label
        return label.removesuffix("_dot")

    # Numbers

    def _vanishes(self, sums: Sequence[tuple[Node, ...]]) -> bool:
        """Say whether sums of terms vanish at all sampled configurations, up to rounding."""
        for point in self._points:
            for terms in sums:
                values = np.array(self._tape.evaluate(terms, point))
                size = np.abs(values).max(initial=0.0)
                # 1e-3 in SI units at unit speed: terms below it may be rounding themselves
                if abs(values.sum()) > SAME * max(size, 1e-3):
                    return False
        return True


def _configurations(system: Mechanism, whole: VectorFields) -> Iterator[dict[str, float]]:
    """Yield random configurations at which the equations of motion have a solution."""
    outputs = [*whole.drift, *(node for slope in whole.inputs.values() for node in slope)]
    velocities = dict.fromkeys(whole.names, 1.0)
    for values in islice(feasible_values(SymbolTable.of(system)), 1, None):
        with suppress(ArithmeticError, ValueError):
            if np.isfinite(whole.tape.evaluate(outputs, velocities | values)).all():
                yield values


def _independent(A: Array) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return velocities and inputs, as many as the rank, between which the effect is regular.

    Those are taken whose determinant, rows of unit size, stays the largest over the points.

    Args:
        A: Effect of the inputs on velocities at the points, shape (points, nv, nu).
    """
    sizes = np.abs(A).max(axis=(0, 2), initial=1e-300)
    A = A / sizes[:, None] / np.abs(A / sizes[:, None]).max(axis=(0, 1), initial=1e-300)
    ranks = [int(np.linalg.matrix_rank(a, tol=FULL_RANK * np.linalg.norm(a, 2))) for a in A]
    rank = max(ranks)

    def worst(choice: tuple[tuple[int, ...], tuple[int, ...]]) -> float:
        return float(np.abs(np.linalg.det(A[:, choice[0]][:, :, choice[1]])).min())

    choices = (
        (rows, columns)
        for rows in combinations(range(A.shape[1]), rank)
        for columns in combinations(range(A.shape[2]), rank)
    )
    return max(choices, key=worst)
