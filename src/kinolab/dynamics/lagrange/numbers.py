"""The one rule for numbers that are read: a short fraction, otherwise a decimal."""

from __future__ import annotations

from fractions import Fraction

import sympy

from kinolab.dynamics.lagrange.terms import fraction

# largest denominator of a fraction printed as such, tenths excepted
MAX_DENOMINATOR = 12
# the same for fractions that do not come from decimals, as in energies
MAX_BINARY_DENOMINATOR = 64


def short_number(value: Fraction) -> sympy.Expr:
    """Return a number for printing: a short fraction, or a decimal where it came from one."""
    bottom = value.denominator
    if (bottom <= MAX_DENOMINATOR and bottom != 10) or (
        bottom <= MAX_BINARY_DENOMINATOR and (bottom % 5 or not bottom % 3)
    ):
        return sympy.Rational(value.numerator, bottom)
    return sympy.Float(float(value))


def with_short_numbers(expression: sympy.Expr) -> sympy.Expr:
    """Return an expression with its numbers rounded for printing."""
    numbers = expression.atoms(sympy.Float)
    return expression.xreplace({number: short_number(fraction(number)) for number in numbers})
