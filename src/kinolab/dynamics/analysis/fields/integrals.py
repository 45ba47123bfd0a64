"""First integrals in the configuration of integrable velocity constraints."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import TypeAlias

import sympy

from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import tangent_symbols
from kinolab.dynamics.symbols.expressions import as_written
from kinolab.dynamics.symbols.symbols import Coordinate, TurnRate

Slopes: TypeAlias = Mapping[Coordinate, sympy.Expr]  # partial derivatives, by coordinate

FACTOR_DIGITS = 9  # of a factor; further ones are rounding


def integral_of(system: Mechanism, factors: Mapping[str, float]) -> sympy.Expr | None:
    """Return h(q) whose rate is a constant combination of constraints, if easily found.

    Args:
        factors: Coefficients of the constraints, by name; missing ones are 0.

    Returns:
        An expression in the author's symbols, up to a constant; None where the combination is no
        exact differential, or where SymPy finds no elementary antiderivative.

    Source: Flanders, Differential Forms, 1963, section 3.6 (Poincare's lemma).
    """
    terms = (
        as_written(round(factors[c.name], FACTOR_DIGITS)) * c.velocity
        for c in system.constraints
        if factors.get(c.name)
    )
    slopes = _slopes(system, sympy.Add(*terms))
    if slopes is None or not _closed(slopes):
        return None
    return _potential(slopes)


def _slopes(system: Mechanism, velocity: sympy.Expr) -> Slopes | None:
    """Return the coefficient of each rate; None where an attitude rotates or one is too long."""
    found = {}
    for symbol in tangent_symbols(system):
        factor = sympy.diff(velocity, symbol)
        if factor == 0:
            continue
        # 200 operations of a partial derivative that SymPy integrates quickly
        if isinstance(symbol, TurnRate) or factor.count_ops() > 200:
            return None
        factor = sympy.trigsimp(sympy.expand(factor))
        if factor != 0:
            found[symbol.coordinate] = factor
    return found


def _closed(slopes: Slopes) -> bool:
    """Return whether partial derivatives form an exact differential: mixed ones agree."""
    pairs = combinations(slopes.items(), 2)
    gaps = (sympy.diff(a, y) - sympy.diff(b, x) for (x, a), (y, b) in pairs)
    others = (
        sympy.diff(a, other)
        for a in slopes.values()
        for other in a.free_symbols
        if isinstance(other, Coordinate) and other not in slopes
    )
    return all(sympy.trigsimp(sympy.expand(gap)) == 0 for gap in (*gaps, *others))


def _potential(slopes: Slopes) -> sympy.Expr | None:
    """Integrate along one coordinate after the other."""
    from sympy.integrals.manualintegrate import manualintegrate

    total = sympy.Integer(0)
    for x, slope in slopes.items():
        rest = sympy.trigsimp(sympy.expand(slope - sympy.diff(total, x)))
        part = manualintegrate(rest, x)
        if part.has(sympy.Integral):
            return None
        total += part
    return -total if total.could_extract_minus_sign() else total
