"""Taylor series in time with interval coefficients, and their derivatives by what they start from.

A coefficient is an interval array (rows, m): the first row is the value, and each further one the
derivative by one entry of what the series start from, over m boxes at once. What does not change
with time has a single coefficient.

Source: Moore, Kearfott, Cloud, Introduction to Interval Analysis, SIAM 2009, chapter 9.
"""

from __future__ import annotations

from functools import reduce

import numpy as np

from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.intervals import IntervalArray

UNIT = np.finfo(float).eps


class Expansion:
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
        self.low = _beside(self.low, coefficient.low)
        self.high = _beside(self.high, coefficient.high)


def _beside(known: Array, further: Array) -> Array:
    """Return coefficients (n, rows, m) and one more, whose rows and boxes may be one for all."""
    if known.shape[1:] != further.shape:
        shape = np.broadcast_shapes(known.shape[1:], further.shape)
        known = np.broadcast_to(known, (len(known), *shape))
        further = np.broadcast_to(further, shape)
    return np.concatenate([known, further[None]])


def summed(low: Array, high: Array) -> IntervalArray:
    """Return the sums of intervals (n, ...) along the first axis, rounding included."""
    size = np.maximum(np.abs(low), np.abs(high)).sum(axis=0)
    # a product and a sum of n terms err by n units at most, and so does the bound of that
    slack = (len(low) + 4) * UNIT * size + intervals.SMALLEST
    least, most = low.sum(axis=0) - slack, high.sum(axis=0) + slack
    bad = np.isnan(least) | np.isnan(most)  # of sums of what has no bound
    return IntervalArray(np.where(bad, -np.inf, least), np.where(bad, np.inf, most))


def products(a: tuple[Array, Array], b: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return lower and upper ends (...) of products of intervals, without rounding.

    Zero times what has no bound is zero, as of ``intervals.mul``: the number itself is finite.

    Args:
        a: Lower and upper ends, each of shape (...).
        b: The same of the other factor.
    """
    ends = [x * y for x in a for y in b]
    low, high = reduce(np.minimum, ends), reduce(np.maximum, ends)
    if np.isnan(low).any():
        ends = [np.where(np.isnan(end), 0.0, end) for end in ends]
        low, high = reduce(np.minimum, ends), reduce(np.maximum, ends)
    return low, high


def convolved(
    a: Expansion,
    b: Expansion,
    n: int,
    first: int = 0,
    last: int | None = None,
    weight: float | None = None,
) -> IntervalArray | None:
    """Return the sum over k of a_k b_(n-k), with derivatives; None where it has no term.

    Args:
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
    rest = summed(low, high)
    if left[0].shape[1] > 1:
        rest = intervals.add(rest, _rows(found))
    return _joined(_row(found), rest)


def added(a: IntervalArray, b: IntervalArray) -> IntervalArray:
    """Return the sum of coefficients, of which one may have no derivatives."""
    a, b = alike(a, b)
    return intervals.add(a, b)


def scaled(a: IntervalArray, factor: float) -> IntervalArray:
    """Return a multiple of a coefficient."""
    low, high = (a.low, a.high) if factor >= 0 else (a.high, a.low)
    return intervals.add(IntervalArray(factor * low, factor * high), intervals.point(0.0))


def quotient(a: IntervalArray, b: IntervalArray) -> IntervalArray:
    """Return the quotient of coefficients, with its derivatives."""
    a, b = alike(a, b)
    value = intervals.div(_row(a), _row(b))
    if len(a.low) == 1:
        return value
    rest = intervals.sub(_rows(a), intervals.mul(value, _rows(b)))
    return _joined(value, intervals.div(rest, _row(b)))


def alike(a: IntervalArray, b: IntervalArray) -> tuple[IntervalArray, IntervalArray]:
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
    if value.low.shape[1:] == rest.low.shape[1:]:
        ends = (value.low, rest.low), (value.high, rest.high)
        return IntervalArray(*(np.concatenate(pair) for pair in ends))
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
