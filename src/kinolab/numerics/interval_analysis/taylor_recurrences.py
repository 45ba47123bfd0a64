"""Taylor coefficients of operations from those of their operands, order by order.

Source: Griewank, Walther, Evaluating Derivatives, 2nd ed., 2008, section 13.2; Moore, Kearfott,
Cloud, Introduction to Interval Analysis, SIAM 2009, section 9.3.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from kinolab.numerics import intervals
from kinolab.numerics.interval_analysis.interval_series import (
    Expansion,
    added,
    alike,
    beginning,
    convolved,
    quotient,
    scaled,
)
from kinolab.numerics.intervals import IntervalArray

Rule: TypeAlias = Callable[
    [int, list[Expansion], Expansion, dict[str, Expansion]], IntervalArray | None
]


def further(
    name: str,
    n: int,
    operands: list[Expansion],
    own: Expansion,
    helper: dict[str, Expansion],
) -> IntervalArray:
    """Return the coefficient of order n >= 1 of an operation whose lower ones are known.

    Args:
        name: Of the operation, as in ``ON_INTERVALS``.
        operands: Their series, known to order n.
        own: The operation's series, known to order n - 1.
        helper: Other series that the recurrence needs, kept with the operation.
    """
    if name in OF_OPERANDS:
        found = OF_OPERANDS[name](n, operands)
    else:
        found = RULES[name](n, operands, own, helper)
    return IntervalArray(np.zeros((1, 1)), np.zeros((1, 1))) if found is None else found


def _at(a: Expansion, n: int) -> IntervalArray | None:
    return a[n] if n < len(a) else None


def _plus(a: IntervalArray | None, b: IntervalArray | None, sign: int = 1) -> IntervalArray | None:
    if b is not None and sign < 0:
        b = intervals.neg(b)
    if a is None or b is None:
        return b if a is None else a
    return added(a, b)


def _over(a: IntervalArray | None, b: IntervalArray) -> IntervalArray | None:
    return None if a is None else quotient(a, b)


def _div(
    n: int, of: list[Expansion], own: Expansion, _: dict[str, Expansion]
) -> IntervalArray | None:
    rest = _plus(_at(of[0], n), convolved(of[1], own, n, 1), -1)
    return _over(rest, of[1][0])


def _sqrt(
    n: int, of: list[Expansion], own: Expansion, _: dict[str, Expansion]
) -> IntervalArray | None:
    rest = _plus(_at(of[0], n), convolved(own, own, n, 1, n - 1), -1)
    return _over(rest, scaled(own[0], 2.0))


def _exp(
    n: int, of: list[Expansion], own: Expansion, _: dict[str, Expansion]
) -> IntervalArray | None:
    return convolved(of[0], own, n, 1, weight=1.0 / n)


def _log(
    n: int, of: list[Expansion], own: Expansion, _: dict[str, Expansion]
) -> IntervalArray | None:
    rest = _plus(_at(of[0], n), convolved(own, of[0], n, 1, n - 1, 1.0 / n), -1)
    return _over(rest, of[0][0])


def _wave(other: str, sign: float) -> Rule:
    """Return the rule of a sine (cos, 1) or a cosine (sin, -1), beside which the other one goes."""

    def rule(
        n: int, of: list[Expansion], own: Expansion, helper: dict[str, Expansion]
    ) -> IntervalArray | None:
        beside = helper.setdefault(other, Expansion(beginning(other, [of[0][0]]), steady=False))
        if len(beside) < n:  # its coefficient of order n - 1, by its own rule
            made = convolved(of[0], own, n - 1, 1, weight=-sign / (n - 1))
            beside.append(
                IntervalArray(np.zeros((1, 1)), np.zeros((1, 1))) if made is None else made
            )
        return convolved(of[0], beside, n, 1, weight=sign / n)

    return rule


def _from_square(sign: int) -> Rule:
    """Return the rule of y' = (1 + sign y^2) a': the tangent (1) or tanh (-1)."""

    def rule(
        n: int, of: list[Expansion], own: Expansion, helper: dict[str, Expansion]
    ) -> IntervalArray | None:
        while len(helper.setdefault("square", Expansion(_square(own, 0), steady=False))) < n:
            helper["square"].append(_square(own, len(helper["square"])))
        rest = convolved(of[0], helper["square"], n, 1, weight=sign / n)
        return _plus(_at(of[0], n), rest)

    return rule


def _square(own: Expansion, n: int) -> IntervalArray:
    if n == 0:
        return beginning("mul", [own[0]] * 2)
    made = convolved(own, own, n)
    assert made is not None
    return made


def _atan(
    n: int, of: list[Expansion], own: Expansion, helper: dict[str, Expansion]
) -> IntervalArray | None:
    one = IntervalArray(np.ones((1, 1)), np.ones((1, 1)))
    below = helper.setdefault("below", Expansion(added(_square(of[0], 0), one), steady=False))
    while len(below) < n:
        below.append(_square(of[0], len(below)))
    rest = convolved(own, below, n, 1, n - 1, 1.0 / n)
    return _over(_plus(_at(of[0], n), rest, -1), below[0])


def _kink(n: int, of: list[Expansion]) -> IntervalArray | None:
    """Return what a magnitude's coefficient is where the sign is known; elsewhere it has none."""
    a, slope = of[0], _at(of[0], n)
    if slope is None:
        return None
    low, high = a.low[0, :1], a.high[0, :1]
    least = np.where(low > 0, slope.low, np.where(high < 0, -slope.high, -np.inf))
    most = np.where(low > 0, slope.high, np.where(high < 0, -slope.low, np.inf))
    return IntervalArray(least, most)


def _larger(n: int, of: list[Expansion]) -> IntervalArray | None:
    a, b = of
    zero = IntervalArray(np.zeros((1, 1)), np.zeros((1, 1)))
    x, y = alike(_at(a, n) or zero, _at(b, n) or zero)
    first, second = a.low[0, :1] > b.high[0, :1], b.low[0, :1] > a.high[0, :1]
    least = np.where(first, x.low, np.where(second, y.low, -np.inf))
    most = np.where(first, x.high, np.where(second, y.high, np.inf))
    return IntervalArray(least, most)


def _jump(_: int, of: list[Expansion]) -> IntervalArray | None:
    known = (of[0].low[0, :1] > 0) | (of[0].high[0, :1] < 0)
    return IntervalArray(np.where(known, 0.0, -np.inf), np.where(known, 0.0, np.inf))


RULES: dict[str, Rule] = {
    "div": _div,
    "sqrt": _sqrt,
    "exp": _exp,
    "log": _log,
    "sin": _wave("cos", 1.0),
    "cos": _wave("sin", -1.0),
    "tan": _from_square(1),
    "tanh": _from_square(-1),
    "atan": _atan,
}
OF_OPERANDS: dict[str, Callable[[int, list[Expansion]], IntervalArray | None]] = {
    "add": lambda n, of: _plus(_at(of[0], n), _at(of[1], n)),
    "sub": lambda n, of: _plus(_at(of[0], n), _at(of[1], n), -1),
    "neg": lambda n, of: _plus(None, _at(of[0], n), -1),
    "mul": lambda n, of: convolved(of[0], of[1], n),
    "fabs": _kink,
    "fmax": _larger,
    "sign": _jump,
}
