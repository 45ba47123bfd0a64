"""Series in time with their derivatives by initial values and inputs, through expression graphs.

A series is an array (K, 1 + D): Taylor coefficients of a function of time in the first column, and
their derivatives by D parameters, such as the initial state, in the others.

Source: Griewank, Walther, Evaluating Derivatives, 2nd ed., 2008, section 13.2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from kinolab.dynamics.analysis.jets.taylor_series import taylor
from kinolab.dynamics.derivation.expression_graph import UNARY, ExpressionGraph, Node
from kinolab.numerics.arrays import Array


def series_of(
    tape: ExpressionGraph, outputs: Sequence[Node], known: Mapping[str, Array | float]
) -> list[Array]:
    """Return what nodes are along a motion.

    Args:
        tape: The expression graph.
        known: The series of variables, shape (K, 1 + D) each, or constants, by label.

    Raises:
        ArithmeticError: Where the expressions are undefined.
    """
    shape = next(value.shape for value in known.values() if isinstance(value, np.ndarray))

    def leaf(node: Node) -> Array | float:
        operation = tape.operations[node]
        return operation.value if operation.name == "const" else known[operation.label]

    functions: dict[str, Any] = {
        **{name: partial(_function, name) for name in UNARY},
        **{"neg": lambda a: -a, "add": _sum, "sub": lambda a, b: _sum(a, -b)},
        **{"mul": _product, "div": _quotient, "fmax": _larger},
    }
    try:
        with np.errstate(all="ignore"):  # what is no number is found out by those who compare
            return [_whole(value, shape) for value in tape.folded(outputs, leaf, functions)]
    except ValueError as error:  # such as the logarithm of a negative number
        raise ArithmeticError(str(error)) from error


def _whole(value: Array | float, shape: tuple[int, ...]) -> Array:
    if isinstance(value, np.ndarray):
        return value
    constant = np.zeros(shape)
    constant[0, 0] = value
    return constant


def _toeplitz(a: Array) -> Array:
    """Return the matrix of the product with a series of numbers, shape (K, K)."""
    k = np.arange(len(a))
    lag = k[:, None] - k
    return np.where(lag >= 0, a[lag], 0.0)


def _sum(a: Any, b: Any) -> Any:
    if isinstance(a, np.ndarray) != isinstance(b, np.ndarray):
        series, number = (a.copy(), b) if isinstance(a, np.ndarray) else (b.copy(), a)
        series[0, 0] += number
        return series
    return a + b


def _product(a: Any, b: Any) -> Any:
    if not (isinstance(a, np.ndarray) and isinstance(b, np.ndarray)):
        return a * b
    made = _toeplitz(a[:, 0]) @ b
    made[:, 1:] += _toeplitz(b[:, 0]) @ a[:, 1:]
    return made


def _quotient(a: Any, b: Any) -> Any:
    return _product(a, _function("reciprocal", b) if isinstance(b, np.ndarray) else 1.0 / b)


def _larger(a: Any, b: Any) -> Any:
    one, other = (value[0, 0] if isinstance(value, np.ndarray) else value for value in (a, b))
    return a if one >= other else b


def _function(name: str, a: Any) -> Any:
    """Apply a function: the series of its value, and of its slope times the derivatives."""
    if not isinstance(a, np.ndarray):
        return UNARY[name](a)
    local = _coefficients(name, float(a[0, 0]), len(a))
    change = _toeplitz(np.append(0.0, a[1:, 0]))
    made = np.empty_like(a)
    made[:, 0] = _composed(local[:-1], change)
    slope = _composed(local[1:] * np.arange(1, len(local)), change)
    made[:, 1:] = _toeplitz(slope) @ a[:, 1:]
    return made


def _coefficients(name: str, at: float, order: int) -> Array:
    if name == "reciprocal":
        if at == 0.0:
            raise ZeroDivisionError("an expression divides by zero at this state")
        return np.asarray((-1.0 / at) ** np.arange(order + 1) / at, dtype=float)
    return np.array(taylor(name, at, order, lambda n, value: UNARY[n](value)), dtype=float)


def _composed(coefficients: Array, change: Array) -> Array:
    """Return the series of sum of c_k h^k for the Toeplitz matrix of h, by Horner's rule."""
    total = np.zeros(len(change))
    for c in coefficients[::-1]:
        total = change @ total
        total[0] += c
    return total
