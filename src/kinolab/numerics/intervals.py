"""Interval arithmetic on arrays: enclosures of what functions do over whole boxes.

Every result contains all values that the operation has on its operands, rounding included.

Source: Moore, Kearfott, Cloud, Introduction to Interval Analysis, SIAM 2009, chapters 2 and 5.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from kinolab.numerics.arrays import Array

QUARTER = np.pi / 2
# NumPy's functions are good to two of the numbers next to the true value, or to the smallest one.
ROUNDING, SMALLEST = 4.0 * np.finfo(float).eps, 4.0 * np.finfo(float).smallest_subnormal


@dataclass(frozen=True, eq=False)
class IntervalArray:
    """Intervals, one for each entry of two arrays of the same shape (...).

    Attributes:
        low: Lower ends.
        high: Upper ends.
    """

    low: Array
    high: Array

    @property
    def width(self) -> Array:
        """How wide each is."""
        return self.high - self.low

    @property
    def magnitude(self) -> Array:
        """The largest magnitude in each."""
        return np.maximum(np.abs(self.low), np.abs(self.high))

    @property
    def mignitude(self) -> Array:
        """The smallest magnitude in each."""
        return np.maximum(np.maximum(self.low, -self.high), 0.0)


def point(value: Array | float) -> IntervalArray:
    """Return intervals of one number each, of the shape (...) of ``value``."""
    number = np.asarray(value, dtype=float)
    return IntervalArray(number, number)


def _outward(low: Array, high: Array) -> IntervalArray:
    """Return intervals that are wider by what rounding may have taken; NaN becomes anything."""
    low = low - (ROUNDING * np.abs(low) + SMALLEST)
    high = high + (ROUNDING * np.abs(high) + SMALLEST)
    if not (low <= high).all():  # NaN, or what was infinite
        low = np.where(np.isnan(low), -np.inf, low)
        high = np.where(np.isnan(high), np.inf, high)
    return IntervalArray(low, high)


def wider(a: IntervalArray) -> IntervalArray:
    """Return intervals that contain what sums of a dozen terms of such size may be off by."""
    slack = 4e-15 * a.magnitude
    return IntervalArray(a.low - slack, a.high + slack)


def add(a: IntervalArray, b: IntervalArray) -> IntervalArray:
    """Return a + b."""
    return _outward(a.low + b.low, a.high + b.high)


def sub(a: IntervalArray, b: IntervalArray) -> IntervalArray:
    """Return a - b."""
    return _outward(a.low - b.high, a.high - b.low)


def neg(a: IntervalArray) -> IntervalArray:
    """Return -a."""
    return IntervalArray(-a.high, -a.low)


def mul(a: IntervalArray, b: IntervalArray) -> IntervalArray:
    """Return a b; zero times anything is zero."""
    products = [x * y for x in (a.low, a.high) for y in (b.low, b.high)]
    low, high = reduce(np.minimum, products), reduce(np.maximum, products)
    if not (low <= high).all():  # zero times infinity
        products = [np.where(np.isnan(product), 0.0, product) for product in products]
        low, high = reduce(np.minimum, products), reduce(np.maximum, products)
    return _outward(low, high)


def square(a: IntervalArray) -> IntervalArray:
    """Return a^2, which is never negative, where ``mul(a, a)`` may be."""
    magnitude = fabs(a)
    found = _outward(magnitude.low**2, magnitude.high**2)
    return IntervalArray(np.maximum(found.low, 0.0), found.high)


def div(a: IntervalArray, b: IntervalArray) -> IntervalArray:
    """Return a / b; anything where b may be zero."""
    zero = (b.low <= 0) & (b.high >= 0)
    inverse = _outward(1.0 / np.where(zero, 1.0, b.high), 1.0 / np.where(zero, 1.0, b.low))
    found = mul(a, inverse)
    return IntervalArray(np.where(zero, -np.inf, found.low), np.where(zero, np.inf, found.high))


def _rising(function: Callable[[Array], Array]) -> Callable[[IntervalArray], IntervalArray]:
    return lambda a: _outward(function(a.low), function(a.high))


def _has_multiple(a: IntervalArray, phase: float) -> Array:
    """Whether an interval holds phase + 2 pi k for a whole k; too often rather than too rarely."""
    turns = 4 * QUARTER
    slack = 1e-12 * (1.0 + a.magnitude)
    first = np.ceil((a.low - slack - phase) / turns)
    return np.asarray(phase + first * turns <= a.high + slack)


def sin(a: IntervalArray) -> IntervalArray:
    """Return the sine."""
    return _wave(np.sin, a, QUARTER)


def cos(a: IntervalArray) -> IntervalArray:
    """Return the cosine."""
    return _wave(np.cos, a, 0.0)


def _wave(function: Callable[[Array], Array], a: IntervalArray, crest: float) -> IntervalArray:
    """Return what a sine of some phase does, with crests at ``crest`` + 2 pi k."""
    ends = function(a.low), function(a.high)
    found = _outward(np.minimum(*ends), np.maximum(*ends))
    wild = ~np.isfinite(a.width)
    trough = wild | _has_multiple(a, crest - 2 * QUARTER)
    low = np.where(trough, -1.0, np.maximum(found.low, -1.0))
    high = np.where(wild | _has_multiple(a, crest), 1.0, np.minimum(found.high, 1.0))
    return IntervalArray(low, high)


def tan(a: IntervalArray) -> IntervalArray:
    """Return the tangent; anything where a pole may be inside."""
    found = _outward(np.tan(a.low), np.tan(a.high))
    pole = ~np.isfinite(a.width) | _has_multiple(a, QUARTER) | _has_multiple(a, -QUARTER)
    return IntervalArray(np.where(pole, -np.inf, found.low), np.where(pole, np.inf, found.high))


def sqrt(a: IntervalArray) -> IntervalArray:
    """Return the square root; of what may be negative, that of the rest."""
    found = _outward(np.sqrt(np.maximum(a.low, 0.0)), np.sqrt(np.maximum(a.high, 0.0)))
    return IntervalArray(np.maximum(found.low, 0.0), found.high)


def fabs(a: IntervalArray) -> IntervalArray:
    """Return the magnitude."""
    return IntervalArray(a.mignitude, a.magnitude)


def maximum(a: IntervalArray, b: IntervalArray) -> IntervalArray:
    """Return the larger of two."""
    return IntervalArray(np.maximum(a.low, b.low), np.maximum(a.high, b.high))


def log(a: IntervalArray) -> IntervalArray:
    """Return the logarithm; of what may not be positive, anything below."""
    positive = a.low > 0
    low = np.where(positive, np.log(np.where(positive, a.low, 1.0)), -np.inf)
    high = np.where(a.high > 0, np.log(np.where(a.high > 0, a.high, 1.0)), -np.inf)
    return _outward(low, high)


ON_INTERVALS: dict[str, Callable[..., IntervalArray]] = {
    **{"add": add, "sub": sub, "mul": mul, "div": div, "neg": neg, "fmax": maximum},
    **{"sin": sin, "cos": cos, "tan": tan, "sqrt": sqrt, "fabs": fabs, "log": log},
    **{"exp": _rising(np.exp), "tanh": _rising(np.tanh), "atan": _rising(np.arctan)},
    "sign": _rising(np.sign),
}


ONE = point(1.0)
# operand, value -> derivative
OUTER: dict[str, Callable[[IntervalArray, IntervalArray], IntervalArray]] = {
    "fabs": lambda a, _: ON_INTERVALS["sign"](a),
    "sin": lambda a, _: cos(a),
    "cos": lambda a, _: neg(sin(a)),
    "tan": lambda _, f: add(ONE, square(f)),
    "exp": lambda _, f: f,
    "log": lambda a, _: div(ONE, a),
    "sqrt": lambda _, f: div(ONE, add(f, f)),
    "tanh": lambda _, f: sub(ONE, square(f)),
    "atan": lambda a, _: div(ONE, add(ONE, square(a))),
}


def slope_of(
    name: str, k: int, operands: Sequence[IntervalArray], value: IntervalArray, d: IntervalArray
) -> IntervalArray:
    """Enclose the derivative of an operation as far as it comes from one of its operands.

    Where an operation has a kink, all slopes between those beside it count, so that the mean value
    theorem holds; where it jumps, any.

    Args:
        name: Of the operation, as in ``ON_INTERVALS``.
        k: Which operand.
        value: The enclosure of the operation.

    Source: Clarke, Optimization and Nonsmooth Analysis, 1983, section 2.3.
    """
    own, other = operands[k], operands[1 - k] if len(operands) > 1 else operands[k]
    match name:
        case "add":
            return d
        case "sub":
            return neg(d) if k else d
        case "neg":
            return neg(d)
        case "mul":
            return mul(d, other)
        case "div":
            return div(neg(mul(d, value)) if k else d, operands[1])
        case "fmax":
            least, most = own.low > other.high, own.high >= other.low
            share = IntervalArray(np.where(least, 1.0, 0.0), np.where(most, 1.0, 0.0))
            return mul(share, d)
        case "sign":
            smooth = (own.low > 0.0) | (own.high < 0.0) | ((d.low == 0.0) & (d.high == 0.0))
            return IntervalArray(np.where(smooth, 0.0, -np.inf), np.where(smooth, 0.0, np.inf))
    return mul(OUTER[name](own, value), d)
