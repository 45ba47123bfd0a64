"""Equations of motion as data, and the Taylor coefficients of their solutions over boxes.

They are kept on disk beside a machine's code, so that only the first proof about it needs symbols.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics.derivation.cancellation import Cancellation
from kinolab.dynamics.derivation.expression_graph import Operation
from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.dynamics.model import Model
from kinolab.numerics import intervals
from kinolab.numerics.interval_analysis.interval_matrices import meet
from kinolab.numerics.interval_analysis.interval_series import (
    Expansion,
    beginning,
    products,
    scaled,
    summed,
)
from kinolab.numerics.interval_analysis.taylor_recurrences import further
from kinolab.numerics.intervals import IntervalArray
from kinolab.store import pickled


@dataclass(frozen=True)
class FlowFormulas:
    """The equations of motion of a machine without modes.

    Attributes:
        names: Of the entries of the state, then of the inputs, then of the parameters.
        nx: Number of entries of the state.
        rates: The derivative of the state, length nx.
        cables: World positions of both ends of every cable, 6 per cable.
    """

    names: tuple[str, ...]
    nx: int
    rates: Formulas
    cables: Formulas

    @classmethod
    def of(cls, model: Model) -> FlowFormulas:
        """Return those of a machine, without its feedback."""
        plant = model.plant
        return KEPT.get([f"{plant.key} flow and cables"], lambda: cls._derived(plant))

    @classmethod
    def _derived(cls, plant: Model) -> FlowFormulas:
        from kinolab.dynamics.codegen.derived_code import derivations_of

        (d,) = derivations_of(plant.system)
        tape = d.binding.tape
        shorter = Cancellation(tape).rewritten(d.derivative)
        rates = min(d.derivative, shorter, key=lambda nodes: len(tape.needed(nodes)))
        names = [tape.operations[node].label for nodes in d.arguments.values() for node in nodes]
        return cls(
            tuple(names), len(d.state), Formulas.of(tape, rates), Formulas.of(tape, d.cables)
        )

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

    def along(self, coefficients: list[IntervalArray]) -> list[IntervalArray]:
        """Enclose the rates' Taylor coefficients along a curve, as the function ``along``."""
        return along(self.rates, self.names, coefficients)


def along(
    formulas: Formulas, names: Sequence[str], coefficients: list[IntervalArray]
) -> list[IntervalArray]:
    """Enclose the Taylor coefficients of formulas along a curve of their variables.

    Args:
        formulas: Functions of the variables.
        names: Of the variables.
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
        if n == 0 and len(coefficients) > 2:
            tape.first = _changes(formulas, names, coefficients)
    return found


def _changes(
    formulas: Formulas, names: Sequence[str], coefficients: list[IntervalArray]
) -> list[IntervalArray]:
    """Enclose the coefficients of order 1 of all operations, each by its own gradient.

    Made of its operands' coefficients, it would forget that these come from the same entries.

    Args:
        formulas: Functions of the variables.
        names: Of the variables.
        coefficients: As of ``along``.
    """
    count, m = coefficients[0].low.shape
    unit = intervals.point(np.repeat(np.eye(count)[:, :, None], m, axis=2))
    variables = [Expansion(one, steady=False) for one in _starts(coefficients[0], unit)]
    tape = _Tape(formulas, names, variables)
    tape.order(0)
    by, found = (coefficients[1].low, coefficients[1].high), []
    for series in tape.series:
        low, high = (
            products((series.low[0, 1:], series.high[0, 1:]), by)
            if series.low.shape[1] > 1
            else (np.zeros((1, 1)),) * 2
        )
        found.append(summed(low, high))
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
        self.first: list[IntervalArray] | None = None  # coefficients of order 1 that are known

    def order(self, n: int) -> list[IntervalArray]:
        """Return the functions' coefficients of order n, once the variables' are known."""
        for k, operation in enumerate(self.operations):
            operands = [self.series[j] for j in operation.operands]
            if n == 0:
                self.series.append(self._beginning(operation, operands))
            elif operands and not self.series[k].steady:
                own, helper = self.series[k], self.helpers[k]
                made = further(operation.name, n, operands, own, helper)
                own.append(self._closer(k, made) if n == 1 else made)
        zero = intervals.point(np.zeros((1, 1)))
        return [self.series[k][n] if n < len(self.series[k]) else zero for k in self.ends]

    def _closer(self, k: int, made: IntervalArray) -> IntervalArray:
        """Return what two enclosures of an operation's coefficient of order 1 have in common."""
        if self.first is None:
            return made
        return meet(made, IntervalArray(self.first[k].low[None], self.first[k].high[None]))

    def _beginning(self, operation: Operation, operands: Sequence[Expansion]) -> Expansion:
        if operation.name == "variable":
            return self.variables[operation.label]
        if operation.name == "const":
            return Expansion(intervals.point(np.full((1, 1), operation.value)), steady=True)
        first = beginning(operation.name, [a[0] for a in operands])
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


KEPT = pickled("flow", FlowFormulas)
