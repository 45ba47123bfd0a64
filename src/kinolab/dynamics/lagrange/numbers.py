"""The one rule for numbers that are read: a short fraction, otherwise a decimal.

In equations a number, its double and its half are written one way: 7/5 and 7/10, or 0.3 and 0.15.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import TypeAlias

import sympy

from kinolab.dynamics.lagrange.terms import fraction

Family: TypeAlias = tuple[int, int]  # odd parts of numerator and denominator
Families: TypeAlias = dict[Family, bool]  # whether they are written as decimals


def short_number(value: Fraction) -> sympy.Expr:
    """Return a number for printing: a short fraction, or a decimal where it came from one."""
    bottom = value.denominator
    # 12: largest denominator of a fraction printed as such, tenths excepted
    # 64: the same for fractions that do not come from decimals, as in energies
    if (bottom <= 12 and bottom != 10) or (bottom <= 64 and (bottom % 5 or not bottom % 3)):
        return sympy.Rational(value.numerator, bottom)
    return sympy.Float(float(value))


def with_short_numbers(expression: sympy.Expr) -> sympy.Expr:
    """Return an expression with its numbers rounded for printing."""
    numbers = expression.atoms(sympy.Float)
    return expression.xreplace({number: short_number(fraction(number)) for number in numbers})


def number_families(expressions: Iterable[sympy.Expr]) -> Families:
    """Return how numbers that end as decimals are written where some expressions belong together.

    Doubles and halves of each other are a family. It is written as decimals if one of them needs
    more than one place, as fractions if fifths stand beside tenths.
    """
    bottoms: dict[Family, set[int]] = {}
    for expression in expressions:
        for value in _ending(expression).values():
            bottoms.setdefault(_family(value), set()).add(value.denominator)
    return {f: max(own) > 10 for f, own in bottoms.items() if max(own) > 10 or len(own) > 1}


def written_alike(expression: sympy.Expr, families: Families) -> sympy.Expr:
    """Return an expression with its numbers as they are printed, each family's written one way."""
    expression, made = with_short_numbers(expression), dict[sympy.Expr, sympy.Expr]()
    for number, value in _ending(expression).items():
        decimal = families.get(_family(value))
        if decimal is not None:
            exact = sympy.Rational(value.numerator, value.denominator)
            made[number] = sympy.Float(float(value)) if decimal else exact
    return expression.xreplace(made)


def _ending(expression: sympy.Expr) -> dict[sympy.Expr, Fraction]:
    """Return the numbers of an expression that end as decimals, and are no binary fractions."""
    numbers = {n: fraction(n) for n in expression.atoms(sympy.Float, sympy.Rational)}
    return {n: v for n, v in numbers.items() if v.denominator % 5 == 0 and _ends(v.denominator)}


def _ends(bottom: int) -> bool:
    """Whether 1 / bottom ends as a decimal."""
    odd = _odd_part(bottom)
    while odd % 5 == 0:
        odd //= 5
    return odd == 1


def _family(value: Fraction) -> Family:
    """Return what doubles and halves of a number have in common."""
    return _odd_part(abs(value.numerator)), _odd_part(value.denominator)


def _odd_part(number: int) -> int:
    return number // (number & -number) if number else 0
