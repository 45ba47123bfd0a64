"""Equations of motion as data, and the Taylor coefficients of their solutions over boxes.

They are kept on disk beside a machine's code, so that only the first proof about it needs symbols.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.derivation.cancellation import Cancellation
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node, Operation
from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.dynamics.model.model import Model
from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.interval_analysis.implicit_derivatives import Balance, Ball, solved
from kinolab.numerics.interval_analysis.interval_matrices import middle
from kinolab.numerics.interval_analysis.interval_series import Expansion, beginning, scaled
from kinolab.numerics.interval_analysis.second_derivatives import (
    Pairs,
    SecondOrder,
    closer,
    operation,
)
from kinolab.numerics.interval_analysis.taylor_recurrences import further
from kinolab.numerics.intervals import IntervalArray
from kinolab.store import pickled


@dataclass(frozen=True, eq=False)
class FlowFormulas:
    """The equations of motion of a machine without modes.

    Attributes:
        names: Of the entries of the state, then of the inputs, then of the parameters.
        nx: Number of entries of the state.
        rates: The derivative of the state, length nx.
        cables: World positions of both ends of every cable, 6 per cable.
        solved: The n entries of the state whose derivatives are T a, where a solves M a = F.
        mixed: T, shape (n, n).
        direct: The derivatives of all other entries, then M, row-major, and F.
    """

    names: tuple[str, ...]
    nx: int
    rates: Formulas
    cables: Formulas
    solved: tuple[int, ...]
    mixed: Array
    direct: Formulas

    @classmethod
    def of(cls, model: Model) -> FlowFormulas:
        """Return those of a machine, without its feedback."""
        plant = model.plant
        return KEPT.get(
            [f"{plant.key} flow, cables and decoupled sides"], lambda: cls._derived(plant)
        )

    @classmethod
    def _derived(cls, plant: Model) -> FlowFormulas:
        from kinolab.dynamics.codegen.derived_code import derivations_of

        (d,) = derivations_of(plant.system)
        tape = d.binding.tape
        cancelled = Cancellation(tape, anew=True)

        def shorter(nodes: Sequence[Node]) -> Sequence[Node]:
            found = cancelled.rewritten(nodes)
            return min(nodes, found, key=lambda some: len(tape.needed(some)))

        rates = shorter(d.derivative)
        names = [tape.operations[node].label for nodes in d.arguments.values() for node in nodes]
        solved, matrix, load = d.balance
        others = [node for k, node in enumerate(rates) if k not in solved]
        mixed, balance = _decoupled(tape, cancelled.rewritten([*matrix, *load]), len(solved))
        direct = Formulas.of(tape, shorter([*others, *balance]))
        formulas = Formulas.of(tape, rates), Formulas.of(tape, d.cables)
        return cls(tuple(names), len(d.state), *formulas, solved, mixed, direct)

    def coefficients(
        self, boxes: IntervalArray, orders: int, slopes: IntervalArray | None = None
    ) -> list[IntervalArray]:
        """Enclose the Taylor coefficients in time of the solutions that start in boxes.

        Inputs and parameters stay as they are.

        Args:
            boxes: Of states, inputs and parameters, shape (entries, m).
            orders: How many: those of order 0, 1, ..., orders.
            slopes: Derivatives of all entries by what derivatives are wanted of, shape
                (entries, wanted, m); None for values alone.

        Returns:
            For each order an interval array (nx, 1 + wanted, m): values, then derivatives; infinite
            where there is no bound.
        """
        starts = _starts(boxes, slopes)
        variables = [Expansion(one, steady=i >= self.nx) for i, one in enumerate(starts)]
        tape, shape = _Tape(self.rates, self.names, variables), starts[0].low.shape
        found = [_stacked(starts[: self.nx], shape)]
        for n in range(orders):
            rates = [scaled(rate, 1.0 / (n + 1)) for rate in tape.order(n)]
            found.append(_stacked(rates, shape))
            for i, variable in enumerate(variables[: self.nx]):
                variable.append(IntervalArray(found[-1].low[i], found[-1].high[i]))
        return found

    def second_order(
        self, boxes: IntervalArray, varied: NDArray[np.intp], *, bent: bool
    ) -> tuple[Ball, Ball | None]:
        """Enclose the rates' first and second derivatives by some of the entries over m boxes.

        Args:
            boxes: Of states, inputs and parameters, shape (entries, m).
            varied: Which of them, length E; all others are numbers, or the rates do not depend on
                them.
            bent: Whether second derivatives are wanted.

        Returns:
            Gradients (nx, E, m), and second derivatives (nx, E, E, m) if they are wanted; of
            infinite radius where there is no bound.
        """
        pairs, at = Pairs(len(varied)), middle(boxes)
        off = intervals.sub(boxes, intervals.point(at))
        off = IntervalArray(off.low[varied], off.high[varied])
        made = self._evaluated(boxes, at, off, varied, pairs, bent=bent)
        n, m = len(self.solved), boxes.low.shape[1]
        over, centre = (_Derivatives.of(one, pairs, len(varied), m) for one in made)
        if not n:
            return over.slopes, over.bends if bent else None
        rest = len(made[0]) - n * n - n
        rows = [k for k in range(self.nx) if k not in self.solved]
        accelerations = solved(
            over.balance(rest, n, bent=bent), centre.balance(rest, n, bent=False), off.magnitude
        )
        order, T = np.argsort([*rows, *self.solved]), Ball(self.mixed, 0.0 * self.mixed)
        slopes = _beside(over.slopes, rest, T.times("ij,jem->iem", accelerations[0]), order)
        bends = accelerations[1]
        if bends is not None:
            bends = T.times("ij,jefm->iefm", bends)
        return slopes, None if bends is None else _beside(over.bends, rest, bends, order)

    def _evaluated(
        self,
        boxes: IntervalArray,
        at: Array,
        off: IntervalArray,
        varied: NDArray[np.intp],
        pairs: Pairs,
        *,
        bent: bool,
    ) -> tuple[list[SecondOrder], list[SecondOrder]]:
        """Return what ``direct`` is over boxes, and in a point of each."""
        starts = self._starting(boxes, varied), self._starting(intervals.point(at), varied)
        operations, ends = self.direct.operations, self.direct.ends
        last = {k: n for n, one in enumerate(operations) for k in one.operands}
        last |= dict.fromkeys(ends, len(operations))
        known: list[tuple[SecondOrder, SecondOrder]] = []
        for n, one in enumerate(operations):
            if one.name in ("variable", "const"):
                known.append((_beginning_of(one, starts[0]), _beginning_of(one, starts[1])))
                continue
            of = [known[k] for k in one.operands]
            centre = operation(one.name, [c for _, c in of], pairs, bent=False)
            made = operation(one.name, [a for a, _ in of], pairs, bent=bent)
            known.append((closer(made, centre, off, pairs), centre))
            for k in one.operands:  # large, and not needed any more
                known[k] = NONE if last[k] == n else known[k]
        return [known[k][0] for k in ends], [known[k][1] for k in ends]

    def _starting(self, boxes: IntervalArray, varied: NDArray[np.intp]) -> dict[str, SecondOrder]:
        """Return the entries by name, with the gradients of those that vary."""
        found = {
            name: SecondOrder(IntervalArray(boxes.low[k], boxes.high[k]))
            for k, name in enumerate(self.names)
        }
        for row, k in enumerate(varied):
            unit = np.zeros((len(varied), 1))
            unit[row] = 1.0
            name = self.names[k]
            found[name] = replace(found[name], slope=intervals.point(unit))
        return found


def _decoupled(tape: ExpressionGraph, balance: Sequence[Node], n: int) -> tuple[Array, list[Node]]:
    """Return T, and T' M T and T' F of M, row-major, and F: fewer of them cancel over intervals.

    Where two accelerations have the same inertia, such as those of two wheels, their sum and their
    difference do not depend on each other.
    """
    M, F = np.reshape(balance[: n * n], (n, n)), [*balance[n * n :]]
    T, free = np.eye(n), set(range(n))
    for i, j in combinations(range(n), 2):
        if not {i, j} <= free or M[i, i] != M[j, j] or M[i, j] == tape.zero:
            continue
        free -= {i, j}
        T[[i, j, j], [j, i, j]] = 1.0, 1.0, -1.0
        F[i], F[j] = tape.add(F[i], F[j]), tape.sub(F[i], F[j])
        for rows in (M, M.T):
            pairs = list(zip(rows[i].tolist(), rows[j].tolist(), strict=True))
            rows[i] = [tape.add(a, b) for a, b in pairs]
            rows[j] = [tape.sub(a, b) for a, b in pairs]
    return T, [*M.ravel().tolist(), *F]


def _beginning_of(one: Operation, starts: Mapping[str, SecondOrder]) -> SecondOrder:
    if one.name == "const":
        return SecondOrder(intervals.point(np.full(1, one.value)))
    return starts[one.label]


@dataclass(frozen=True, eq=False)
class _Derivatives:
    """Functions over m boxes below each other.

    Attributes:
        values: Shape (n, m).
        slopes: Shape (n, E, m).
        bends: Shape (n, E, E, m).
    """

    values: Ball
    slopes: Ball
    bends: Ball

    @classmethod
    def of(cls, rows: Sequence[SecondOrder], pairs: Pairs, count: int, m: int) -> _Derivatives:
        """Return them as balls; what is no number is anything."""
        bends = _filled([one.bend for one in rows], (len(pairs.first), m))
        full = Ball(bends.centre[:, pairs.place], bends.radius[:, pairs.place])
        slopes = _filled([one.slope for one in rows], (count, m))
        return cls(_filled([one.value for one in rows], (m,)), slopes, full)

    def balance(self, first: int, n: int, *, bent: bool) -> Balance:
        """Return the functions from the first one on as M, row-major, and F."""

        def sides(one: Ball) -> tuple[Ball, Ball]:
            c, r = one.centre[first:], one.radius[first:]
            square = (n, n, *c.shape[1:])
            matrix = Ball(c[: n * n].reshape(square), r[: n * n].reshape(square))
            return matrix, Ball(c[n * n :], r[n * n :])

        (M, F), (M1, F1), (M2, F2) = (sides(a) for a in (self.values, self.slopes, self.bends))
        return Balance(M, M1, M2 if bent else None, F, F1, F2 if bent else None)


def _filled(rows: Sequence[IntervalArray | None], shape: tuple[int, ...]) -> Ball:
    """Return arrays of the same shape below each other; what is no number is anything."""
    low, high = np.zeros((len(rows), *shape)), np.zeros((len(rows), *shape))
    for i, one in enumerate(rows):
        if one is not None:
            low[i], high[i] = one.low, one.high
    bad = ~(np.isfinite(low) & np.isfinite(high))
    found = Ball.of(np.where(bad, 0.0, low), np.where(bad, 0.0, high))
    return Ball(found.centre, np.where(bad, np.inf, found.radius))


def _beside(a: Ball, count: int, b: Ball, order: NDArray[np.intp]) -> Ball:
    """Return the first rows of one and those of another one, in an order."""
    centre = np.concatenate([a.centre[:count], b.centre])[order]
    return Ball(centre, np.concatenate([a.radius[:count], b.radius])[order])


def along(
    formulas: Formulas, names: Sequence[str], coefficients: list[IntervalArray]
) -> list[IntervalArray]:
    """Enclose the Taylor coefficients of formulas along a curve of their variables.

    Args:
        formulas: Functions of the variables.
        coefficients: Of the curve, for each order a box (variables, m) that holds it at all points.

    Returns:
        Of the functions, for each order an interval array (functions, m); infinite where there is
        no bound.
    """
    variables = [Expansion(one, steady=False) for one in _starts(coefficients[0], None)]
    tape, shape, found = _Tape(formulas, names, variables), (1, coefficients[0].low.shape[1]), []
    for n, one in enumerate(coefficients):
        if n:
            for variable, coefficient in zip(variables, _starts(one, None), strict=True):
                variable.append(coefficient)
        made = _stacked(tape.order(n), shape)
        found.append(IntervalArray(made.low[:, 0], made.high[:, 0]))
    return found


class _Tape:
    """The operations of formulas, each with as many Taylor coefficients as are known."""

    def __init__(
        self, formulas: Formulas, names: Sequence[str], variables: Sequence[Expansion]
    ) -> None:
        self.operations, self.ends = formulas.operations, formulas.ends
        self.variables = dict(zip(names, variables, strict=True))
        self.series: list[Expansion] = []
        self.helpers: list[dict[str, Expansion]] = [{} for _ in self.operations]

    def order(self, n: int) -> list[IntervalArray]:
        """Return the functions' coefficients of order n, once the variables' are known."""
        for k, one in enumerate(self.operations):
            operands = [self.series[j] for j in one.operands]
            if n == 0:
                self.series.append(self._beginning(one, operands))
            elif operands and not self.series[k].steady:
                own, helper = self.series[k], self.helpers[k]
                own.append(further(one.name, n, operands, own, helper))
        zero = intervals.point(np.zeros((1, 1)))
        return [self.series[k][n] if n < len(self.series[k]) else zero for k in self.ends]

    def _beginning(self, one: Operation, operands: Sequence[Expansion]) -> Expansion:
        if one.name == "variable":
            return self.variables[one.label]
        if one.name == "const":
            return Expansion(intervals.point(np.full((1, 1), one.value)), steady=True)
        first = beginning(one.name, [a[0] for a in operands])
        return Expansion(first, steady=all(a.steady for a in operands))


def _starts(boxes: IntervalArray, slopes: IntervalArray | None) -> list[IntervalArray]:
    """Return the coefficient of order 0 of each entry, shape (1 + wanted, m)."""
    lows, highs = boxes.low[:, None], boxes.high[:, None]
    if slopes is not None:
        lows = np.concatenate([lows, slopes.low], axis=1)
        highs = np.concatenate([highs, slopes.high], axis=1)
    return [IntervalArray(low, high) for low, high in zip(lows, highs, strict=True)]


def _stacked(rows: Sequence[IntervalArray], shape: tuple[int, ...]) -> IntervalArray:
    """Return coefficients below each other; what is no number is anything."""
    low, high = np.zeros((len(rows), *shape)), np.zeros((len(rows), *shape))
    for i, one in enumerate(rows):  # derivatives that are missing are 0
        low[i, : len(one.low)], high[i, : len(one.high)] = one.low, one.high
    bad = np.isnan(low) | np.isnan(high)
    return IntervalArray(np.where(bad, -np.inf, low), np.where(bad, np.inf, high))


NONE = (SecondOrder(intervals.point(0.0)),) * 2
KEPT = pickled("flow", FlowFormulas)
