"""Whether an expression is a length or an angle, found from what its symbols are."""

from __future__ import annotations

import math

import sympy

from kinolab.dynamics.symbols.symbols import Coordinate, Parameter, RateSymbol, TurnRate

ANGLE, OPEN = "rad", "m or rad"  # OPEN: a bare number may be a length, 0.3 cos(a)


def unit_of(expression: sympy.Expr) -> str:
    """Return the unit of an expression, time ignored: m, rad, or both where that is open."""
    dimension = _dimension(expression)
    if isinstance(dimension, str):
        return dimension
    return "m" if dimension == 1 else f"m^{dimension:g}"


def rate_unit_of(expression: sympy.Expr) -> str:
    """Return the unit of a velocity: m/s, rad/s, or both where that is open."""
    unit = unit_of(expression)
    return "m/s or rad/s" if unit == OPEN else f"{unit}/s"


def _dimension(expression: sympy.Expr) -> str | float:
    """Return the exponent of length in an expression's dimension, time ignored, ANGLE or OPEN."""
    if expression.is_Symbol:
        owner = expression.coordinate if isinstance(expression, RateSymbol) else expression
        if isinstance(expression, TurnRate):
            return ANGLE
        unit = owner.unit if isinstance(owner, Coordinate | Parameter) else ""
        return 1.0 if unit == "m" else ANGLE if unit == "rad" else OPEN
    parts = [_dimension(part) for part in expression.args]
    lengths = [part for part in parts if not isinstance(part, str)]
    if isinstance(expression, sympy.Add):
        return lengths[0] if lengths else ANGLE if set(parts) == {ANGLE} else OPEN
    if isinstance(expression, sympy.Mul) and math.fsum(lengths):
        return math.fsum(lengths)
    if isinstance(expression, sympy.Mul) and not lengths:
        whole = all(f.is_Integer for f in expression.args if f.is_number)
        plain = all(f.is_number or d == ANGLE for f, d in zip(expression.args, parts, strict=True))
        return ANGLE if whole and plain else OPEN
    if isinstance(expression, sympy.Pow) and lengths and expression.exp.is_number:
        return lengths[0] * float(expression.exp)
    return OPEN
