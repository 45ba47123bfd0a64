"""Values, gradients and second derivatives of formulas over boxes, each as tight as the next gives.

A value over a box is enclosed by itself, and by the value in the middle and what the gradient adds;
a gradient by itself, and by that in the middle and what the second derivatives add. What cancels in
a formula, such as the parts of a determinant, thereby cancels in its enclosure to first order.

Source: Hansen, A generalized interval arithmetic, Interval Mathematics, LNCS 29, 1975; Moore,
Kearfott, Cloud, Introduction to Interval Analysis, SIAM 2009, section 6.4 (mean value forms);
Griewank, Walther, Evaluating Derivatives, 2nd ed., 2008, section 5.1 (second derivatives).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.interval_analysis.interval_matrices import meet
from kinolab.numerics.interval_analysis.interval_series import products, summed
from kinolab.numerics.intervals import ONE, OUTER, IntervalArray


@dataclass(frozen=True, eq=False)
class SecondOrder:
    """A function over m boxes, of E entries that vary.

    Attributes:
        value: Shape (m,).
        slope: Gradient, shape (E, m); None where it is constant.
        bend: Second derivatives by the pairs of ``Pairs``, (pairs, m); None where these are 0.
    """

    value: IntervalArray
    slope: IntervalArray | None = None
    bend: IntervalArray | None = None


class Pairs:
    """The pairs (i, j) of E entries with i <= j, in the order in which ``bend`` has them."""

    def __init__(self, count: int) -> None:
        self.first, self.second = (np.asarray(a, np.intp) for a in np.triu_indices(count))
        self.place = np.zeros((count, count), dtype=np.intp)
        self.place[self.first, self.second] = np.arange(len(self.first))
        self.place[self.second, self.first] = np.arange(len(self.first))

    def outer(self, a: IntervalArray, b: IntervalArray) -> IntervalArray:
        """Return a_i b_j + a_j b_i for all pairs, of gradients (E, m)."""
        i, j = self.first, self.second
        return intervals.add(
            intervals.mul(_rows(a, i), _rows(b, j)), intervals.mul(_rows(a, j), _rows(b, i))
        )

    def applied(self, bend: IntervalArray, off: IntervalArray) -> IntervalArray:
        """Return the products of second derivatives and deviations (E, m), shape (E, m)."""
        return summed(*products((bend.low[self.place], bend.high[self.place]), _each(off)))


def _rows(a: IntervalArray, rows: NDArray[np.intp]) -> IntervalArray:
    return IntervalArray(a.low[rows], a.high[rows])


def _each(off: IntervalArray) -> tuple[Array, Array]:
    return off.low[:, None], off.high[:, None]


def operation(
    name: str, operands: Sequence[SecondOrder], pairs: Pairs, *, bent: bool
) -> SecondOrder:
    """Return an operation with its derivatives, made of its operands'.

    Args:
        name: Of the operation, as in ``ON_INTERVALS``.
        operands: What it is applied to.
        bent: Whether second derivatives are wanted.
    """
    values = [a.value for a in operands]
    same = name == "mul" and operands[0] is operands[1]
    value = intervals.square(values[0]) if same else intervals.ON_INTERVALS[name](*values)
    slope: IntervalArray | None = None
    for k, a in enumerate(operands):
        if a.slope is not None:
            part = intervals.slope_of(name, k, values, value, a.slope)
            slope = part if slope is None else intervals.add(slope, part)
    if slope is None or not bent:
        return SecondOrder(value, slope)
    bend = _linear(name, operands, value)
    further = _crossed(name, operands, value, slope, pairs)
    if bend is None or further is None:
        return SecondOrder(value, slope, bend or further)
    return SecondOrder(value, slope, intervals.add(bend, further))


def _linear(
    name: str, operands: Sequence[SecondOrder], value: IntervalArray
) -> IntervalArray | None:
    """Return what the operands' second derivatives give: they count as gradients do."""
    found: IntervalArray | None = None
    for k, a in enumerate(operands):
        if a.bend is not None:
            part = intervals.slope_of(name, k, [b.value for b in operands], value, a.bend)
            found = part if found is None else intervals.add(found, part)
    return found


def _crossed(
    name: str,
    operands: Sequence[SecondOrder],
    value: IntervalArray,
    slope: IntervalArray,
    pairs: Pairs,
) -> IntervalArray | None:
    """Return what products of the operands' gradients give, shape (pairs, m)."""
    if name in ("add", "sub", "neg"):
        return None
    if name in ("mul", "div"):
        a, b = operands
        if b.slope is None or (name == "mul" and a.slope is None):
            return None
        if name == "mul":
            assert a.slope is not None
            return pairs.outer(a.slope, b.slope)
        return intervals.div(intervals.neg(pairs.outer(slope, b.slope)), b.value)
    if name == "fmax":
        a, b = operands
        apart = (a.value.low > b.value.high) | (b.value.low > a.value.high)
        return _kinked(apart, slope, pairs)
    (a,) = operands
    assert a.slope is not None
    if name in ("fabs", "sign"):
        return _kinked((a.value.low > 0.0) | (a.value.high < 0.0), slope, pairs)
    curvature = OUTER_TWICE[name](a.value, value)
    half = intervals.mul(curvature, intervals.point(0.5))
    return intervals.mul(pairs.outer(a.slope, a.slope), half)


def _kinked(smooth: NDArray[np.bool_], slope: IntervalArray, pairs: Pairs) -> IntervalArray:
    """Return second derivatives of what has a kink: none beside it, and anything over it."""
    bound = np.where(smooth, 0.0, np.inf)
    still = (slope.low == 0.0) & (slope.high == 0.0)
    none = still[pairs.first] | still[pairs.second]
    return IntervalArray(np.where(none, 0.0, -bound), np.where(none, 0.0, bound))


def closer(
    found: SecondOrder, centre: SecondOrder, off: IntervalArray, pairs: Pairs
) -> SecondOrder:
    """Return a function with what the mean value theorem says of its value and its gradient.

    Args:
        centre: In a point of each box.
        off: The boxes less these points, shape (E, m).
    """
    slope = found.slope
    if slope is None:
        return found
    if found.bend is not None:
        assert centre.slope is not None
        slope = meet(slope, intervals.add(centre.slope, pairs.applied(found.bend, off)))
    change = summed(*products((slope.low, slope.high), (off.low, off.high)))
    return SecondOrder(meet(found.value, intervals.add(centre.value, change)), slope, found.bend)


Curvature = Callable[[IntervalArray, IntervalArray], IntervalArray]


def _twice(a: IntervalArray) -> IntervalArray:
    return intervals.add(a, a)


# operand, value -> second derivative
OUTER_TWICE: dict[str, Curvature] = {
    "sin": lambda _, f: intervals.neg(f),
    "cos": lambda _, f: intervals.neg(f),
    "tan": lambda a, f: intervals.mul(_twice(f), OUTER["tan"](a, f)),
    "exp": lambda _, f: f,
    "log": lambda a, _: intervals.neg(intervals.div(ONE, intervals.square(a))),
    "sqrt": lambda _, f: intervals.div(
        intervals.point(-0.25), intervals.mul(f, intervals.square(f))
    ),
    "tanh": lambda a, f: intervals.neg(intervals.mul(_twice(f), OUTER["tanh"](a, f))),
    "atan": lambda a, f: intervals.neg(
        intervals.mul(_twice(a), intervals.square(OUTER["atan"](a, f)))
    ),
}
