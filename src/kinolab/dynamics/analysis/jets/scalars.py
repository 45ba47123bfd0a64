"""Number types of jets: floats, or rationals and angles with rational sine and cosine."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from fractions import Fraction
from math import isqrt
from typing import Any, final

import numpy as np
import sympy

from kinolab.dynamics.derivation.expression_graph import UNARY
from kinolab.errors import InputError, Mistake


class AbstractNumbers(ABC):
    """A number type for the coefficients of jets."""

    dtype: type

    @abstractmethod
    def constant(self, value: float) -> Any:
        """Convert a number of the machine's description."""

    @abstractmethod
    def function(self, name: str, value: Any) -> Any:
        """Evaluate a function of ``UNARY``."""


@final
class Floats(AbstractNumbers):
    """Floating-point numbers."""

    dtype = float

    def constant(self, value: float) -> float:
        """Return the number unchanged."""
        return value

    def function(self, name: str, value: Any) -> float:
        """Evaluate in floating point."""
        return UNARY[name](float(value))


@final
class Rationals(AbstractNumbers):
    """Rational numbers; an angle may also be a ``Turn``, whose sine and cosine are rational."""

    dtype = object

    def constant(self, value: float) -> Fraction:
        """Return the exact decimal as written: 0.1 is 1/10."""
        return Fraction(repr(value))

    def function(self, name: str, value: Any) -> Any:
        """Evaluate exactly.

        Raises:
            InputError: If the value is not rational.
        """
        if isinstance(value, Turn):
            known = {"sin": value.sine, "cos": value.cosine}
            if name == "tan" and value.cosine:
                return value.sine / value.cosine
            if name in known:
                return known[name]
        elif name == "sign":
            return Fraction((value > 0) - (value < 0))
        elif name == "sqrt" and value >= 0:
            root = Fraction(isqrt(value.numerator), isqrt(value.denominator))
            if root * root == value:
                return root
        elif value == EXACT_VALUES[name]:
            return Fraction(UNARY[name](float(value)))
        what = f"{name}({value}) is not rational."
        remedy = "Give angles as multiples of pi / 2 or as atan of a rational, such as atan(3 / 4)."
        raise InputError([Mistake("exact rank", what, remedy)])


EXACT_VALUES = {"sin": 0, "cos": 0, "tan": 0, "exp": 0, "log": 1, "tanh": 0, "atan": 0, "sqrt": 0}


@final
@dataclass(frozen=True)
class Turn:
    """An angle whose sine and cosine are rational; it can be added and multiplied by integers."""

    cosine: Fraction
    sine: Fraction

    def __add__(self, other: Any) -> Turn:
        if isinstance(other, Turn):
            c, s = self.cosine, self.sine
            return Turn(
                c * other.cosine - s * other.sine,
                s * other.cosine + c * other.sine,
            )
        if other == 0:
            return self
        raise _not_rational(f"an angle plus {other}")

    __radd__ = __add__

    def __neg__(self) -> Turn:
        return Turn(self.cosine, -self.sine)

    def __sub__(self, other: Any) -> Turn:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Turn:
        return self.__neg__().__add__(other)

    def __mul__(self, factor: Any) -> Any:
        if factor == 0:
            return Fraction(0)
        if isinstance(factor, Turn) or Fraction(factor).denominator != 1:
            raise _not_rational(f"{factor} times an angle")
        total = Turn(Fraction(1), Fraction(0))
        for _ in range(abs(int(factor))):
            total = total + self
        return total if factor > 0 else -total

    __rmul__ = __mul__

    def __str__(self) -> str:
        return f"the angle with cosine {self.cosine} and sine {self.sine}"


def _not_rational(what: str) -> InputError:
    remedy = "An exact rank needs this angle at 0, or no exactness."
    return InputError([Mistake("exact rank", f"{what} is not rational.", remedy)])


def rational(name: str, value: Any) -> Any:
    """Convert a user's value of a variable to a rational number or a ``Turn``.

    Args:
        value: A number, or an expression such as ``pi / 2`` or ``atan(Rational(3, 4))``.

    Raises:
        InputError: If it is neither.
    """
    if isinstance(value, Fraction | Turn):
        return value
    if isinstance(value, int | float | np.integer | np.floating):
        return Fraction(repr(value.item() if isinstance(value, np.generic) else value))
    if isinstance(value, sympy.Rational):
        return Fraction(value.p, value.q)
    if isinstance(value, sympy.Expr):
        parts = [sympy.simplify(function(value)) for function in (sympy.cos, sympy.sin)]
        if all(isinstance(part, sympy.Rational) for part in parts):
            return Turn(*(Fraction(part.p, part.q) for part in parts))
    what = f"{value!r} is no rational number, and no angle with rational sine and cosine."
    remedy = "Write a number, pi / 2, or atan(Rational(3, 4))."
    raise InputError([Mistake(f"variable {name!r}", what, remedy)])
