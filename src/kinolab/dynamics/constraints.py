"""Conditions on a machine's motion."""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from kinolab.dynamics.frames import Number


@dataclass(frozen=True)
class Constraint:
    """A velocity that stays zero: w(q) q_dot = 0, held by a force that does no work."""

    velocity: sympy.Expr
    name: str


def zero(velocity: Number, name: str) -> Constraint:
    """State that a velocity, linear in the rates, is zero, such as ``zero(V.y, "no sideslip")``."""
    return Constraint(sympy.sympify(velocity), name)
