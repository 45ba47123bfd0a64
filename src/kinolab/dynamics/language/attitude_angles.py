"""By how much an attitude is turned, as an expression that is smooth where it is not turned."""

from __future__ import annotations

from math import comb
from typing import TypeAlias

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.expressions import exact
from kinolab.dynamics.language.frames import Number
from kinolab.dynamics.language.symbols import Attitude

Quaternion: TypeAlias = tuple[Number, Number, Number, Number]

# Of half the angle, at most pi / 2, an eighth is at most pi / 16 = 0.2, and 1 - cos of that 0.02:
# eight terms leave 3e-18 of the sum of all.
HALVINGS, TERMS = 3, 8


@checked
def squared_turn(attitude: Attitude, rest: Quaternion = (0, 0, 0, 1)) -> sympy.Expr:
    """Return the square of the angle in [rad] by which an attitude is turned from another one.

    The angle is that about a single axis, at most pi. Half the stiffness times this is the energy
    of a ball joint's spring: its torque is along that axis, and reverses at half a turn.

    Args:
        attitude: The attitude.
        rest: A unit quaternion x, y, z, w, from which it is turned.

    Source: Gradshteyn, Ryzhik, Table of Integrals, Series, and Products, 1.645 (arcsin^2).
    """
    entries = attitude.quaternion
    along = sympy.Add(*(exact(r) * q for r, q in zip(rest, entries, strict=True)))
    cosine = sympy.Abs(along) / sympy.sqrt(sympy.Add(*(q**2 for q in entries)))  # of half the angle
    for _ in range(HALVINGS):
        cosine = sympy.sqrt((1 + cosine) / 2)
    # arccos(c)^2 = 2 sum of x^n / (n^2 (2n over n)), with x = 2 (1 - c); by Horner's rule
    x, total = 2 * (1 - cosine), sympy.Integer(0)
    for n in range(TERMS, 0, -1):
        total = x * (sympy.Rational(2, n**2 * comb(2 * n, n)) + total)
    return 4 ** (HALVINGS + 1) * total
