"""Normal forms of expressions: sums of products without squares of sines.

Everything cancels by sin^2 + cos^2 = 1 and by unit quaternion norm. Two expressions of sines,
cosines, quaternions and polynomials are equal if their terms are the same. Used for reading only,
never for compiled code.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import Any, TypeAlias

import sympy

from kinolab.dynamics.symbols.expressions import LARGEST_DENOMINATOR
from kinolab.dynamics.symbols.symbols import Coordinate, QuaternionEntry

Monomial: TypeAlias = frozenset[tuple[sympy.Expr, int]]  # (base, nonzero power)
Terms: TypeAlias = dict[Monomial, Fraction]

ONE: Monomial = frozenset()


class TooLongError(Exception):
    """The expression has too many terms, or the deadline has passed."""


class Expander:
    """Expands expressions into sums of products.

    Args:
        write: Converts terms back to an expression, for arguments of functions and roots.
        deadline: On the clock of ``time.thread_time``, in [s]; expansion stops after it.
        apart: Whether to expand sines and cosines of sums of angles.
    """

    def __init__(
        self, write: Callable[[Terms], sympy.Expr], *, deadline: float, apart: bool
    ) -> None:
        self._write, self._deadline, self._apart = write, deadline, apart
        self._known: dict[sympy.Expr, Terms] = {}

    def terms(self, expression: sympy.Expr) -> Terms:
        """Return the terms of an expression.

        Raises:
            TooLongError: If there are too many terms, or it takes too long.
        """
        if expression not in self._known:
            self._known[expression] = self._terms(expression)
        return self._known[expression]

    def _terms(self, expression: sympy.Expr) -> Terms:
        if expression.is_Rational or expression.is_Float:
            return constant(fraction(expression))
        if expression.is_Add:
            return total(map(self.terms, expression.args))
        if expression.is_Mul:
            return self._product(map(self.terms, expression.args))
        if expression.is_Pow:
            return self._power(*expression.args)
        if isinstance(expression, sympy.sin | sympy.cos | sympy.tan):
            return self._trigonometric(type(expression), expression.args[0])
        if expression.args:
            return self._function(expression)
        return generator(expression)

    def _function(self, expression: sympy.Expr) -> Terms:
        inner = [self._write(self.terms(entry)) for entry in expression.args]
        made: sympy.Expr = expression.func(*inner)
        if isinstance(made, sympy.Abs) and is_positive(made.args[0]):
            made = made.args[0]
        return generator(made) if made.func == expression.func else self.terms(made)

    def _trigonometric(self, function: Any, angle: sympy.Expr) -> Terms:
        if function is sympy.tan:
            sine = self._trigonometric(sympy.sin, angle)
            cosine = self._trigonometric(sympy.cos, angle)
            return self._product([sine, self._root(cosine, sympy.Integer(-1))])
        angle = self._write(self.terms(angle))
        first, rest = _parted(angle) if self._apart else (angle, sympy.Integer(0))
        if rest == 0:
            made = function(angle)
            plain = isinstance(made, function) and made.args[0] == angle
            return generator(made) if plain else self.terms(made)
        sign = 1 if function is sympy.sin else -1
        other = sympy.cos if function is sympy.sin else sympy.sin
        one, two = ((function, sympy.cos), (other, sympy.sin))
        products = [[f(first), g(rest)] for f, g in (one, two)]
        a, b = (self._product(map(self.terms, pair)) for pair in products)
        return total([a, scaled(b, Fraction(sign))])

    def _power(self, base: sympy.Expr, exponent: sympy.Expr) -> Terms:
        if exponent.is_Integer and exponent > 0:
            return self._product([self.terms(base)] * int(exponent))
        if exponent.is_Rational:
            return self._root(self.terms(base), exponent)
        return generator(sympy.Pow(self._write(self.terms(base)), exponent))

    def _root(self, base: Terms, exponent: sympy.Rational) -> Terms:
        """Return a negative or fractional power of terms; of a single term, expanded."""
        if len(base) == 1:
            ((monomial, factor),) = base.items()
            powers = [(entry, power * exponent) for entry, power in monomial]
            if all(power.is_Integer for _, power in powers) and _has_root(factor, exponent):
                made = {_signless(e, p, exponent): int(p) for e, p in powers}
                return {frozenset(made.items()): fraction(sympy.Pow(_rational(factor), exponent))}
        written = self._write(base)
        if not exponent.is_Integer:
            root = sympy.Pow(written, sympy.Rational(1, exponent.q))
            return {frozenset({(root, int(exponent.p))}): Fraction(1)}
        return {frozenset({(written, int(exponent))}): Fraction(1)}

    def _product(self, factors: Iterable[Terms]) -> Terms:
        made = constant(Fraction(1))
        for factor in factors:
            # 40_000 terms of a product of two sums
            if len(made) * len(factor) > 40_000 or time.thread_time() > self._deadline:
                raise TooLongError
            pairs = ((_times(m, n), a * b) for m, a in made.items() for n, b in factor.items())
            made = reduced(pairs)
            if len(made) > 1200:  # of a sum, intermediate or final
                raise TooLongError
        return made


def constant(value: Fraction) -> Terms:
    """Return the terms of a number."""
    return {ONE: value} if value else {}


def generator(base: sympy.Expr) -> Terms:
    """Return the terms of an expression treated as an indeterminate."""
    return {frozenset({(base, 1)}): Fraction(1)}


def scaled(terms: Terms, factor: Fraction) -> Terms:
    """Return terms multiplied by a number."""
    return {monomial: factor * value for monomial, value in terms.items()}


def total(parts: Iterable[Terms]) -> Terms:
    """Return the sum of terms."""
    return reduced((m, a) for part in parts for m, a in part.items())


def reduced(pairs: Iterable[tuple[Monomial, Fraction]]) -> Terms:
    """Collect terms, with squares of sines and of quaternions' last entries replaced."""
    made: Terms = {}
    stack = list(pairs)
    while stack:
        monomial, factor = stack.pop()
        square = next((b for b, power in monomial if power >= 2 and _is_replaced(b)), None)
        if square is None:
            made[monomial] = made.get(monomial, Fraction(0)) + factor
            continue
        rest = _times(monomial, frozenset({(square, -2)}))
        stack.append((rest, factor))
        stack += [(_times(rest, frozenset({(b, 2)})), -factor) for b in _others(square)]
    return {monomial: factor for monomial, factor in made.items() if factor}


def is_positive(expression: sympy.Expr) -> bool:
    """Whether an expression is nonnegative, by assumption or by a coordinate's limits."""
    if isinstance(expression, Coordinate):
        return expression.lower >= 0
    return bool(expression.is_nonnegative)


def _is_replaced(base: sympy.Expr) -> bool:
    return isinstance(base, sympy.sin) or (isinstance(base, QuaternionEntry) and base.index == 3)


def _others(square: sympy.Expr) -> tuple[sympy.Expr, ...]:
    """Return the bases whose squares sum to 1 with that of a sine or quaternion entry w."""
    if isinstance(square, QuaternionEntry):
        return tuple(square.attitude.quaternion[:3])
    return (sympy.cos(square.args[0]),)


def _times(one: Monomial, other: Monomial) -> Monomial:
    powers = dict(one)
    for base, power in other:
        powers[base] = powers.get(base, 0) + power
        if not powers[base]:
            del powers[base]
    return frozenset(powers.items())


def _parted(angle: sympy.Expr) -> tuple[sympy.Expr, sympy.Expr]:
    """Split a sum, or a small multiple, of angles into one angle and the rest, which may be 0."""
    if angle.is_Add:
        first = min(angle.args, key=str)
        return first, angle - first
    number, one = angle.as_coeff_Mul()
    # Multiples up to 3, whose sine is expanded in sin and cos of the angle
    if number.is_Integer and 2 <= abs(number) <= 3:
        return one * sympy.sign(number), angle - one * sympy.sign(number)
    return angle, sympy.Integer(0)


def _has_root(factor: Fraction, exponent: sympy.Rational) -> bool:
    if exponent.is_Integer:
        return True
    return bool(factor > 0 and sympy.Pow(_rational(factor), exponent).is_Rational)


def _signless(base: sympy.Expr, power: sympy.Rational, exponent: sympy.Rational) -> sympy.Expr:
    """Return the base of a root of a power: sqrt(x^2) is |x|."""
    if exponent.is_Integer or is_positive(base) or int(power) % 2 == 0:
        return base
    return sympy.Abs(base)


def _rational(value: Fraction) -> sympy.Rational:
    return sympy.Rational(value.numerator, value.denominator)


def fraction(number: sympy.Expr) -> Fraction:
    """Return a number as the exact decimal fraction: 0.1 is 1/10."""
    if number.is_Rational:
        return Fraction(int(number.p), int(number.q))
    value = float(number)
    near = Fraction(value).limit_denominator(LARGEST_DENOMINATOR)
    return near if float(near) == value else Fraction(value)
