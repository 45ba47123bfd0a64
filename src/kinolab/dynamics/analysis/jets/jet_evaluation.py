"""Evaluation of expression graph nodes on jets: Taylor expansion about a point."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from kinolab.dynamics.analysis.jets.jets import Jet, JetSpace, jet_space
from kinolab.dynamics.analysis.jets.scalars import AbstractNumbers
from kinolab.dynamics.analysis.jets.taylor_series import taylor
from kinolab.dynamics.derivation.expression_graph import UNARY, ExpressionGraph, Node


def jets_of(
    tape: ExpressionGraph,
    outputs: Sequence[Node],
    variables: Sequence[Node],
    values: Mapping[str, Any],
    order: int,
    numbers: AbstractNumbers,
) -> Jet:
    """Expand nodes in Taylor polynomials about a point.

    Args:
        tape: The expression graph.
        outputs: Nodes to expand.
        variables: Variables of the expansion.
        values: Values of all variables, by label; those of ``variables`` are the point.
        order: Highest degree.

    Returns:
        Jets, shape (outputs, size).

    Raises:
        ArithmeticError, ValueError: Where the expressions are undefined.
    """
    evaluation = _Evaluation(tape, variables, values, jet_space(len(variables), order), numbers)
    return evaluation(outputs)


class _Evaluation:
    """One pass over an expression graph; constants stay plain numbers."""

    def __init__(
        self,
        tape: ExpressionGraph,
        variables: Sequence[Node],
        values: Mapping[str, Any],
        space: JetSpace,
        numbers: AbstractNumbers,
    ) -> None:
        self.tape, self.values, self.space, self.numbers = tape, values, space, numbers
        self.places = {node: k for k, node in enumerate(variables)}

    def __call__(self, outputs: Sequence[Node]) -> Jet:
        functions: dict[str, Callable[..., Any]] = {
            **{name: partial(self._function, name) for name in UNARY},
            **{"neg": operator.neg, "add": self._sum, "mul": self._product},
            "sub": lambda a, b: self._sum(a, -b),
            "div": lambda a, b: self._product(a, self._reciprocal(b)),
            "fmax": self._larger,
        }
        found = self.tape.folded(outputs, self._leaf, functions)
        return np.array([self._whole(value) for value in found])

    def _leaf(self, node: Node) -> Any:
        operation = self.tape.operations[node]
        if operation.name == "const":
            return self.numbers.constant(operation.value)
        value = self.values[operation.label]
        if node not in self.places:
            return value
        jet = self._whole(value)
        if self.space.order:
            jet[1 + self.places[node]] = self.numbers.constant(1.0)
        return jet

    def _whole(self, value: Any) -> Jet:
        """Promote a number to a jet."""
        if isinstance(value, np.ndarray):
            return value.copy()
        jet: Jet = np.full(self.space.size, self.numbers.constant(0.0), dtype=self.numbers.dtype)
        jet[0] = value
        return jet

    def _larger(self, a: Any, b: Any) -> Any:
        one, other = (value[0] if isinstance(value, np.ndarray) else value for value in (a, b))
        return a if one >= other else b

    def _sum(self, a: Any, b: Any) -> Any:
        if isinstance(a, np.ndarray) != isinstance(b, np.ndarray):
            jet, number = (a.copy(), b) if isinstance(a, np.ndarray) else (b.copy(), a)
            jet[0] = jet[0] + number
            return jet
        return a + b

    def _product(self, a: Any, b: Any) -> Any:
        if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
            return self.space.product(a, b)
        return a * b

    def _reciprocal(self, a: Any) -> Any:
        if not isinstance(a, np.ndarray):
            return 1 / a
        if a[0] == 0:
            raise ZeroDivisionError("an expression divides by zero at this point")
        series = [1 / a[0]]
        for _ in range(self.space.order):
            series.append(-series[-1] / a[0])
        return self._compose(series, a)

    def _function(self, name: str, a: Any) -> Any:
        if not isinstance(a, np.ndarray):
            return self.numbers.function(name, a)
        return self._compose(taylor(name, a[0], self.space.order, self.numbers.function), a)

    def _compose(self, series: Sequence[Any], a: Jet) -> Jet:
        """Compose a Taylor series with a jet, by Horner's rule."""
        change = a.copy()
        change[0] = self.numbers.constant(0.0)
        total = self._whole(series[-1])
        for coefficient in reversed(series[:-1]):
            total = self.space.product(total, change)
            total[0] = total[0] + coefficient
        return total
