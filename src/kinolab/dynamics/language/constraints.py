"""Conditions on a machine's motion: held by forces, or demanded of plans."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.expressions import exact
from kinolab.dynamics.language.frames import Number
from kinolab.dynamics.language.symbols import ForceSymbol


@checked
@dataclass(frozen=True)
class VelocityConstraint:
    """A velocity that stays zero: w(q) q_dot = 0, held by a force that does no work."""

    velocity: sympy.Expr
    name: str


@checked
@dataclass(frozen=True)
class PositionConstraint:
    """A function of position that stays zero: h(q) = 0, held by a force that does no work."""

    position: sympy.Expr
    name: str


Constraint: TypeAlias = VelocityConstraint | PositionConstraint


@checked
@dataclass(frozen=True)
class Requirement:
    """A condition g(x, u) >= 0 that plans must keep, such as a rope that only pulls."""

    margin: sympy.Expr
    name: str


@checked
def zero(velocity: Number, name: str) -> VelocityConstraint:
    """State that a velocity, linear in the rates, is zero, such as ``zero(V.y, "no sideslip")``."""
    return VelocityConstraint(exact(velocity), name)


@checked
def closed(position: Number, name: str) -> PositionConstraint:
    """State that a function of the coordinates is zero, such as a loop that closes."""
    return PositionConstraint(exact(position), name)


@checked
def require(margin: Number, name: str) -> Requirement:
    """Demand of every plan that an expression in states and inputs stays at least zero."""
    return Requirement(exact(margin), name)


@checked
def force_of(constraint: Constraint) -> sympy.Symbol:
    """Return the symbol of a constraint's force, for use in a requirement.

    It is the multiplier: in [N] where the constraint is a velocity in [m/s] or a length in [m].
    Its force on the machine acts towards larger values of what ``zero`` or ``closed`` holds at
    zero. So a taut rope has a positive one where its slack is held, ``closed(L - distance, name)``,
    and a negative one where its stretch is, ``closed(distance - L, name)``: it only pulls where
    ``require(force_of(rope), …)`` holds for the first, ``require(-force_of(rope), …)`` for the
    second.

    Args:
        constraint: What ``zero`` or ``closed`` returned.

    Raises:
        InputError: If it is something else.
    """
    return ForceSymbol(constraint.name)
