"""Taylor series in time with interval coefficients, and their derivatives by what they start from.

A coefficient is an interval array (rows, m): the first row is the value, and each further one the
derivative by one entry of what the series start from, over m boxes at once. What does not change
with time has a single coefficient.

Source: Moore, Kearfott, Cloud, Introduction to Interval Analysis, SIAM 2009, chapter 9; Griewank,
Walther, Evaluating Derivatives, 2nd ed., 2008, section 13.2 (the recurrences).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import TypeAlias

import numpy as np

from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.intervals import IntervalArray

UNIT = np.finfo(float).eps
NOTHING = IntervalArray(np.asarray(-np.inf), np.asarray(np.inf))


class Series:
    """The coefficients of one function of time.

    Args:
        first: The coefficient of order 0, shape (rows, m).
        steady: Whether all further ones are 0.
    """

    def __init__(self, first: IntervalArray, *, steady: bool) -> None:
        self.low, self.high = first.low[None], first.high[None]
        self.steady = steady

    def __getitem__(self, n: int) -> IntervalArray:
        return IntervalArray(self.low[n], self.high[n])

    def __len__(self) -> int:
        return len(self.low)

    def append(self, coefficient: IntervalArray) -> None:
        """Add the coefficient of the next order."""
        low, high = np.broadcast_arrays(coefficient.low, coefficient.high)
        shape = np.broadcast_shapes(self.low.shape[1:], low.shape)
        self.low, self.high = (
            np.concatenate([np.broadcast_to(old, (len(old), *shape)), np.broadcast_to(new, (1, *shape))])
            for old, new in ((self.low, low), (self.high, high))
        )


def summed(low: Array, high: Array) -> IntervalArray:
    """Return the sums of intervals along the first axis, rounding included."""
    size = np.maximum(np.abs(low), np.abs(high)).sum(axis=0)
    # a product and a sum of n terms err by n units at most, and so does the bound of that
    slack = (len(low) + 4) * UNIT * size + intervals.SMALLEST
    least, most = low.sum(axis=0) - slack, high.sum(axis=0) + slack
    bad = np.isnan(least) | np.isnan(most)  # of sums of what has no bound
    return IntervalArray(np.where(bad, -np.inf, least), np.where(bad, np.inf, most))


def products(a: tuple[Array, Array], b: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return lower and upper ends of products of intervals, without rounding.

    Zero times what has no bound is zero, as of ``intervals.mul``: the number itself is finite.
    """
    ends = [x * y for x in a for y in b]
    low, high = reduce(np.minimum, ends), reduce(np.maximum, ends)
    if np.isnan(low).any():
        ends = [np.where(np.isnan(end), 0.0, end) for end in ends]
        low, high = reduce(np.minimum, ends), reduce(np.maximum, ends)
    return low, high


def convolved(
    a: Series, b: Series, n: int, first: int = 0, last: int | None = None, weight: float | None = None
) -> IntervalArray | None:
    """Return the sum over k of a_k b_(n-k), with derivatives; None where it has no term.

    Args:
        a: A series.
        b: A series.
        n: The order.
        first: The first k.
        last: The last k; n where left out.
        weight: Where it is given, terms are multiplied by k times this.
    """
    start = max(first, n - len(b) + 1)
    stop = min(n if last is None else last, len(a) - 1)
    if start > stop:
        return None
    k = np.arange(start, stop + 1)
    left, right = (a.low[k], a.high[k]), (b.low[n - k], b.high[n - k])
    if weight is not None:
        factor = (k * weight)[:, None, None]
        left = left[0] * factor, left[1] * factor
    low, high = products(left, (right[0][:, :1], right[1][:, :1]))
    found = summed(low, high)
    if right[0].shape[1] == 1:
        return found
    low, high = products((left[0][:, :1], left[1][:, :1]), (right[0][:, 1:], right[1][:, 1:]))
    further = summed(low, high)
    if left[0].shape[1] > 1:
        further = intervals.add(further, IntervalArray(found.low[1:], found.high[1:]))
    rows = np.broadcast_shapes(found.low[:1].shape[1:], further.low.shape[1:])
    value = (np.broadcast_to(end[:1], (1, *rows)) for end in (found.low, found.high))
    return IntervalArray(*(np.concatenate(pair) for pair in zip(value, (further.low, further.high), strict=True)))


def added(a: IntervalArray, b: IntervalArray) -> IntervalArray:
    """Return the sum of coefficients, of which one may have no derivatives."""
    a, b = _alike(a, b)
    return intervals.add(a, b)


def scaled(a: IntervalArray, factor: float) -> IntervalArray:
    """Return a multiple of a coefficient."""
    low, high = (a.low, a.high) if factor >= 0 else (a.high, a.low)
    return intervals.add(IntervalArray(factor * low, factor * high), intervals.point(0.0))


def quotient(a: IntervalArray, b: IntervalArray) -> IntervalArray:
    """Return the quotient of coefficients, with its derivatives."""
    a, b = _alike(a, b)
    value = intervals.div(_row(a), _row(b))
    if len(a.low) == 1:
        return value
    rest = intervals.sub(_rows(a), intervals.mul(value, _rows(b)))
    return _joined(value, intervals.div(rest, _row(b)))


def _alike(a: IntervalArray, b: IntervalArray) -> tuple[IntervalArray, IntervalArray]:
    """Return coefficients with as many rows: those that are missing are 0."""
    rows = max(len(a.low), len(b.low))
    return _with_rows(a, rows), _with_rows(b, rows)


def _with_rows(a: IntervalArray, rows: int) -> IntervalArray:
    if len(a.low) == rows:
        return a
    zeros = np.zeros((rows - 1, a.low.shape[1]))
    return IntervalArray(np.concatenate([a.low, zeros]), np.concatenate([a.high, zeros]))


def _row(a: IntervalArray) -> IntervalArray:
    return IntervalArray(a.low[:1], a.high[:1])


def _rows(a: IntervalArray) -> IntervalArray:
    return IntervalArray(a.low[1:], a.high[1:])


def _joined(value: IntervalArray, rest: IntervalArray) -> IntervalArray:
    m = np.broadcast_shapes(value.low.shape[1:], rest.low.shape[1:])
    low, high = (
        np.concatenate([np.broadcast_to(x, (len(x), *m)) for x in pair])
        for pair in ((value.low, rest.low), (value.high, rest.high))
    )
    return IntervalArray(low, high)


# operation, its operands -> the coefficient of order 0
def beginning(name: str, operands: list[IntervalArray]) -> IntervalArray:
    """Return the coefficient of order 0 of an operation, with its derivatives.

    Args:
        name: Of the operation, as in ``ON_INTERVALS``.
        operands: Coefficients of order 0.
    """
    rows = max(len(a.low) for a in operands)
    values = [_row(a) for a in operands]
    same = name == "mul" and operands[0] is operands[1]
    value = intervals.square(values[0]) if same else intervals.ON_INTERVALS[name](*values)
    if rows == 1:
        return value
    slope: IntervalArray | None = None
    for k, a in enumerate(operands):
        if len(a.low) > 1:
            part = intervals.slope_of(name, k, values, value, _rows(a))
            slope = part if slope is None else intervals.add(slope, part)
    assert slope is not None
    return _joined(value, slope)


Rule: TypeAlias = Callable[[int, list[Series], Series, dict[str, Series]], IntervalArray | None]


def further(
    name: str, n: int, operands: list[Series], own: Series, helper: dict[str, Series]
) -> IntervalArray:
    """Return the coefficient of order n >= 1 of an operation whose lower ones are known.

    Args:
        name: Of the operation, as in ``ON_INTERVALS``.
        n: The order.
        operands: Their series, known to order n.
        own: The operation's series, known to order n - 1.
        helper: Other series that the recurrence needs, kept with the operation.
    """
    found = RULES[name](n, operands, own, helper)
    return IntervalArray(np.zeros((1, 1)), np.zeros((1, 1))) if found is None else found


def _at(a: Series, n: int) -> IntervalArray | None:
    return a[n] if n < len(a) else None


def _plus(a: IntervalArray | None, b: IntervalArray | None, sign: int = 1) -> IntervalArray | None:
    if b is not None and sign < 0:
        b = intervals.neg(b)
    if a is None or b is None:
        return b if a is None else a
    return added(a, b)


def _over(a: IntervalArray | None, b: IntervalArray) -> IntervalArray | None:
    return None if a is None else quotient(a, b)


def _div(n: int, of: list[Series], own: Series, _: dict[str, Series]) -> IntervalArray | None:
    rest = _plus(_at(of[0], n), convolved(of[1], own, n, 1), -1)
    return _over(rest, of[1][0])


def _sqrt(n: int, of: list[Series], own: Series, _: dict[str, Series]) -> IntervalArray | None:
    rest = _plus(_at(of[0], n), convolved(own, own, n, 1, n - 1), -1)
    return _over(rest, scaled(own[0], 2.0))


def _exp(n: int, of: list[Series], own: Series, _: dict[str, Series]) -> IntervalArray | None:
    return convolved(of[0], own, n, 1, weight=1.0 / n)


def _log(n: int, of: list[Series], own: Series, _: dict[str, Series]) -> IntervalArray | None:
    rest = _plus(_at(of[0], n), convolved(own, of[0], n, 1, n - 1, 1.0 / n), -1)
    return _over(rest, of[0][0])


def _wave(other: str, sign: float) -> Rule:
    """Return the rule of a sine (cos, 1) or a cosine (sin, -1), beside which the other one goes."""

    def rule(n: int, of: list[Series], own: Series, helper: dict[str, Series]) -> IntervalArray | None:
        beside = helper.setdefault(other, Series(beginning(other, [of[0][0]]), steady=False))
        if len(beside) < n:  # its coefficient of order n - 1, by its own rule
            made = convolved(of[0], own, n - 1, 1, weight=-sign / (n - 1))
            beside.append(IntervalArray(np.zeros((1, 1)), np.zeros((1, 1))) if made is None else made)
        return convolved(of[0], beside, n, 1, weight=sign / n)

    return rule


def _from_square(sign: int) -> Rule:
    """Return the rule of y' = (1 + sign y^2) a': the tangent (1) or tanh (-1)."""

    def rule(n: int, of: list[Series], own: Series, helper: dict[str, Series]) -> IntervalArray | None:
        while len(helper.setdefault("square", Series(_square(own, 0), steady=False))) < n:
            helper["square"].append(_square(own, len(helper["square"])))
        rest = convolved(of[0], helper["square"], n, 1, weight=sign / n)
        return _plus(_at(of[0], n), rest)

    return rule


def _square(own: Series, n: int) -> IntervalArray:
    if n == 0:
        return beginning("mul", [own[0]] * 2)
    made = convolved(own, own, n)
    assert made is not None
    return made


def _atan(n: int, of: list[Series], own: Series, helper: dict[str, Series]) -> IntervalArray | None:
    one = IntervalArray(np.ones((1, 1)), np.ones((1, 1)))
    below = helper.setdefault("below", Series(added(_square(of[0], 0), one), steady=False))
    while len(below) < n:
        below.append(_square(of[0], len(below)))
    rest = convolved(own, below, n, 1, n - 1, 1.0 / n)
    return _over(_plus(_at(of[0], n), rest, -1), below[0])


def _kink(n: int, of: list[Series], own: Series, _: dict[str, Series]) -> IntervalArray | None:
    """Return what a magnitude's coefficient is where the sign is known; elsewhere it has none."""
    a, slope = of[0], _at(of[0], n)
    if slope is None:
        return None
    low, high = a.low[0, :1], a.high[0, :1]
    least = np.where(low > 0, slope.low, np.where(high < 0, -slope.high, -np.inf))
    most = np.where(low > 0, slope.high, np.where(high < 0, -slope.low, np.inf))
    return IntervalArray(least, most)


def _larger(n: int, of: list[Series], own: Series, _: dict[str, Series]) -> IntervalArray | None:
    a, b = of
    zero = IntervalArray(np.zeros((1, 1)), np.zeros((1, 1)))
    x, y = _alike(_at(a, n) or zero, _at(b, n) or zero)
    first, second = a.low[0, :1] > b.high[0, :1], b.low[0, :1] > a.high[0, :1]
    least = np.where(first, x.low, np.where(second, y.low, -np.inf))
    most = np.where(first, x.high, np.where(second, y.high, np.inf))
    return IntervalArray(least, most)


def _jump(n: int, of: list[Series], own: Series, _: dict[str, Series]) -> IntervalArray | None:
    known = (of[0].low[0, :1] > 0) | (of[0].high[0, :1] < 0)
    return IntervalArray(np.where(known, 0.0, -np.inf), np.where(known, 0.0, np.inf))


RULES: dict[str, Rule] = {
    "add": lambda n, of, own, _: _plus(_at(of[0], n), _at(of[1], n)),
    "sub": lambda n, of, own, _: _plus(_at(of[0], n), _at(of[1], n), -1),
    "neg": lambda n, of, own, _: _plus(None, _at(of[0], n), -1),
    "mul": lambda n, of, own, _: convolved(of[0], of[1], n),
    "div": _div,
    "sqrt": _sqrt,
    "exp": _exp,
    "log": _log,
    "sin": _wave("cos", 1.0),
    "cos": _wave("sin", -1.0),
    "tan": _from_square(1),
    "tanh": _from_square(-1),
    "atan": _atan,
    "fabs": _kink,
    "fmax": _larger,
    "sign": _jump,
}
