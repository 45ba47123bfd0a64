"""Taylor coefficients of univariate functions, generic in the number type.

Source: Griewank, Walther, Evaluating Derivatives, 2nd ed., 2008, section 13.2.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, TypeAlias

Number: TypeAlias = Any  # a float, a fractions.Fraction
Function: TypeAlias = Callable[[str, Number], Number]  # a function of UNARY at a number


def taylor(name: str, at: Number, order: int, function: Function) -> list[Number]:
    """Return the coefficients c_k of f(at + h) = sum of c_k h^k, k = 0 … order.

    Args:
        name: Of a function in ``kinolab.dynamics.derivation.expression_graph.UNARY``.
        at: Where to expand.
        order: Of the last coefficient.
        function: Evaluates functions for this number type.
    """
    return RULES[name](at, order, function)


def _waves(name: str, at: Number, order: int, function: Function) -> list[Number]:
    s, c = function("sin", at), function("cos", at)
    cycle = [s, c, -s, -c] if name == "sin" else [c, -s, -c, s]
    found, factorial = [], 1
    for k in range(order + 1):
        factorial *= max(k, 1)
        found.append(cycle[k % 4] / factorial)
    return found


def _exp(at: Number, order: int, function: Function) -> list[Number]:
    found = [function("exp", at)]
    for k in range(1, order + 1):
        found.append(found[-1] / k)
    return found


def _log(at: Number, order: int, function: Function) -> list[Number]:
    return [function("log", at), *(-((-1 / at) ** k) / k for k in range(1, order + 1))]


def _sqrt(at: Number, order: int, function: Function) -> list[Number]:
    found = [function("sqrt", at)]
    for k in range(1, order + 1):
        found.append(found[-1] * (3 - 2 * k) / (2 * k * at))
    return found


def _from_square(name: str, sign: int, at: Number, order: int, function: Function) -> list[Number]:
    """Return what the recurrence of y' = 1 + sign y^2 gives: tan (1) and tanh (-1)."""
    y = [function(name, at)]
    for k in range(order):
        square = sum(y[i] * y[k - i] for i in range(k + 1))
        y.append(((1 if k == 0 else 0) + sign * square) / (k + 1))
    return y


def _atan(at: Number, order: int, function: Function) -> list[Number]:
    """Divide 1 by 1 + (at + h)^2 and integrate."""
    below = 1 + at * at
    slope: list[Number] = []
    for k in range(order):
        rest = 1 if k == 0 else 0
        rest -= 2 * at * slope[k - 1] if k >= 1 else 0
        rest -= slope[k - 2] if k >= 2 else 0
        slope.append(rest / below)
    return [function("atan", at), *(c / (k + 1) for k, c in enumerate(slope))]


RULES: Mapping[str, Callable[[Number, int, Function], list[Number]]] = {
    **{name: partial(_waves, name) for name in ("sin", "cos")},
    **{"tan": partial(_from_square, "tan", 1), "tanh": partial(_from_square, "tanh", -1)},
    **{"exp": _exp, "log": _log, "sqrt": _sqrt, "atan": _atan},
    "fabs": lambda at, order, sign: [abs(at), sign("sign", at), *[0 * at] * order][: order + 1],
    "sign": lambda at, order, sign: [sign("sign", at), *[0 * at] * order],
}
