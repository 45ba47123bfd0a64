"""Conversion of numbers and SymPy expressions; text is never evaluated."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from numbers import Real
from typing import Any

import sympy

from kinolab.errors import InputError, Mistake

LARGEST_DENOMINATOR = 100_000  # of a number taken as an exact decimal, such as 0.0975


def exact(value: Any) -> sympy.Expr:
    """Convert a number or an expression to SymPy.

    Raises:
        InputError: If it is neither, in particular text, which SymPy would run as code.
    """
    if isinstance(value, sympy.Expr):
        return value
    if isinstance(value, Real) and not isinstance(value, bool):
        plain = value if isinstance(value, int) else float(value)
        if math.isfinite(plain):
            return sympy.sympify(plain)
    what = f"{value!r} is neither a finite number nor an expression."
    raise InputError([Mistake("", what, "Write expressions with the machine's symbols.")])


def sympify_fields(record: Any, *names: str) -> None:
    """Convert the numbers in some fields of a frozen dataclass to SymPy, tuples included."""
    for name in names:
        value = getattr(record, name)
        try:
            made = tuple(map(exact, value)) if isinstance(value, tuple) else exact(value)
        except InputError as error:
            where = f"{type(record).__name__} {name}"
            raise InputError([replace(m, where=where) for m in error.mistakes]) from None
        object.__setattr__(record, name, made)


def is_zero(value: Any) -> bool:
    """Whether a number or expression is zero, exactly; SymPy's Float(0.0) does not equal 0."""
    return bool(exact(value).is_zero)


def as_written(value: float) -> sympy.Rational | sympy.Float:
    """Return a number as the rational that was meant: 0.1 is 1/10, and 0.333… is a third.

    A number with a long decimal part remains a float.
    """
    near = Fraction(value).limit_denominator(LARGEST_DENOMINATOR)
    if float(near) == value:
        return sympy.Rational(near.numerator, near.denominator)
    return sympy.Float(value)


def parts_of(expressions: Iterable[sympy.Expr]) -> dict[sympy.Basic, int]:
    """Return how often each part of expressions occurs in others, after those that it contains.

    Where parts are shared, as in laws of feedback, this takes the time of one look at each; SymPy's
    ``free_symbols`` looks at a part as often as it occurs in what is written out.
    """
    uses: dict[sympy.Basic, int] = {}

    def visit(part: sympy.Basic) -> None:
        if part not in uses:
            for argument in part.args:
                visit(argument)
            uses[part] = 0
        uses[part] += 1

    for expression in expressions:
        visit(expression)
    return uses
