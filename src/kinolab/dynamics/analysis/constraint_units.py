"""Units of a machine's constraints, found from the dimensions of their expressions."""

from __future__ import annotations

from kinolab.dynamics.language.constraints import Constraint, PositionConstraint
from kinolab.dynamics.symbols.dimensions import rate_unit_of, unit_of


def position_unit(constraint: PositionConstraint) -> str:
    """Return the unit of h(q): m, rad, or both where bare numbers leave it open."""
    return unit_of(constraint.position)


def velocity_unit(constraint: Constraint) -> str:
    """Return the unit of a constraint's velocity: m/s, rad/s, or both where that is open."""
    if isinstance(constraint, PositionConstraint):
        return rate_unit_of(constraint.position)
    return rate_unit_of(constraint.velocity)
