"""Constraints enforced by forces, and requirements on plans."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.frames import Number, time_derivative
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import ForceSymbol


@checked
@dataclass(frozen=True)
class VelocityConstraint:
    """A velocity constraint w(q) q_dot = 0, enforced by a force that does no work."""

    velocity: sympy.Expr
    name: str

    @property
    def stated(self) -> sympy.Expr:
        """What is zero, as its author wrote it."""
        return self.velocity


@checked
@dataclass(frozen=True)
class PositionConstraint:
    """A position (holonomic) constraint h(q) = 0, enforced by a force that does no work."""

    position: sympy.Expr
    name: str

    @property
    def stated(self) -> sympy.Expr:
        """What is zero, as its author wrote it."""
        return self.position

    @property
    def velocity(self) -> sympy.Expr:
        """The derivative of the position, which is zero, too."""
        return time_derivative(self.position)


Constraint: TypeAlias = VelocityConstraint | PositionConstraint


@checked
@dataclass(frozen=True)
class Requirement:
    """A path constraint g(x, u) >= 0 on plans, such as a rope in tension.

    Attributes:
        margin: The expression g, in states, inputs, parameters and constraint forces.
        name: Its name in certificates.
    """

    margin: sympy.Expr
    name: str


@checked
def zero(velocity: Number, name: str) -> VelocityConstraint:
    """Constrain a velocity, linear in the rates, to zero, such as ``zero(V.y, "no sideslip")``.

    Args:
        velocity: In [m/s] or [rad/s].
        name: Its name in equations and certificates.
    """
    return VelocityConstraint(exact(velocity), name)


@checked
def closed(position: Number, name: str) -> PositionConstraint:
    """Constrain a function of the coordinates to zero, such as a loop closure.

    Args:
        position: In [m] or [rad].
        name: Its name in equations and certificates.
    """
    return PositionConstraint(exact(position), name)


@checked
def require(margin: Number, name: str) -> Requirement:
    """Require an expression in states and inputs to stay nonnegative in every plan.

    Args:
        margin: The expression, of any unit.
        name: Its name in certificates.
    """
    return Requirement(exact(margin), name)


@checked
def force_of(constraint: Constraint) -> sympy.Symbol:
    """Return the symbol of a constraint's force, for use in requirements.

    It is the Lagrange multiplier: in [N] where the constraint is a velocity in [m/s] or a length in
    [m]. A positive one acts towards larger values of the expression in ``zero`` or ``closed``. So a
    taut rope has a positive multiplier if its slack is constrained, ``closed(L - distance, name)``,
    and a negative one if its stretch is, ``closed(distance - L, name)``: it only pulls where
    ``require(force_of(rope), …)`` holds for the first, ``require(-force_of(rope), …)`` for the
    second.

    Args:
        constraint: What ``zero`` or ``closed`` returned.

    Raises:
        InputError: If it is something else.
    """
    return ForceSymbol(constraint.name)
