"""Units of a machine's constraints, found from the dimensions of their expressions."""

from __future__ import annotations

import math

import sympy

from kinolab.dynamics.language.constraints import Constraint, PositionConstraint
from kinolab.dynamics.symbols.symbols import Coordinate, Parameter, RateSymbol, TurnRate

ANGLE, OPEN = "rad", "m or rad"  # OPEN: a bare number may be a length, 0.3 cos(a)


def position_unit(constraint: PositionConstraint) -> str:
    """Return the unit of h(q): m, rad, or both where bare numbers leave it open."""
    return _unit(_dimension(constraint.position))


def velocity_unit(constraint: Constraint) -> str:
    """Return the unit of a constraint's velocity: m/s, rad/s, or both where that is open."""
    if isinstance(constraint, PositionConstraint):
        unit = position_unit(constraint)
    else:
        unit = _unit(_dimension(constraint.velocity))
    return "m/s or rad/s" if unit == OPEN else f"{unit}/s"


def _unit(dimension: str | float) -> str:
    if isinstance(dimension, str):
        return dimension
    return "m" if dimension == 1 else f"m^{dimension:g}"


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
