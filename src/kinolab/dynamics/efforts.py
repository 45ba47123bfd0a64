"""What acts on bodies: inputs with limits, and gravity."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import sympy

from kinolab.dynamics.bodies import Body
from kinolab.dynamics.frames import Axis, Number
from kinolab.dynamics.symbols import InputSymbol
from kinolab.errors import InputError, Mistake

Limit: TypeAlias = float | tuple[float, float]


@dataclass(frozen=True, init=False)
class Torque:
    """An input torque in [N m] on a body about an axis.

    Args:
        name: What scenarios and files call the input.
        on: The body it turns.
        about: The axis; *whose* axis it is matters, for it moves with its frame.
        reacts_on: The body that feels the opposite torque; the world when left out.
        limit: Largest magnitude, or (lower, upper), in [N m].
    """

    name: str
    on: Body
    about: Axis
    reacts_on: Body | None
    bounds: tuple[float, float]

    unit = "N m"

    def __init__(
        self, name: str, *, on: Body, about: Axis, reacts_on: Body | None = None, limit: Limit
    ) -> None:
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "on", on)
        object.__setattr__(self, "about", about)
        object.__setattr__(self, "reacts_on", reacts_on)
        object.__setattr__(self, "bounds", limits(name, limit))

    @property
    def symbol(self) -> InputSymbol:
        """The symbol of the input's value."""
        return InputSymbol(self.name)


@dataclass(frozen=True, init=False)
class Force:
    """An input force in [N] on a body's centre of mass along an axis.

    Args:
        name: What scenarios and files call the input.
        on: The body it pushes.
        along: The direction, which moves with the axis' frame.
        reacts_on: The body that feels the opposite force at its own centre of mass.
        limit: Largest magnitude, or (lower, upper), in [N].
    """

    name: str
    on: Body
    along: Axis
    reacts_on: Body | None
    bounds: tuple[float, float]

    unit = "N"

    def __init__(
        self, name: str, *, on: Body, along: Axis, reacts_on: Body | None = None, limit: Limit
    ) -> None:
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "on", on)
        object.__setattr__(self, "along", along)
        object.__setattr__(self, "reacts_on", reacts_on)
        object.__setattr__(self, "bounds", limits(name, limit))

    @property
    def symbol(self) -> InputSymbol:
        """The symbol of the input's value."""
        return InputSymbol(self.name)


Input: TypeAlias = Torque | Force


@dataclass(frozen=True)
class Gravity:
    """A uniform field: ``strength`` in [m/s^2] along the world direction ``down`` (unit vector)."""

    down: tuple[float, float, float]
    strength: sympy.Expr


def toward(direction: str, strength: Number = 9.81) -> Gravity:
    """Say which way is down, such as ``toward("-z", 9.81)``; the pictures follow.

    Args:
        direction: A world axis with an optional sign: ``"-z"``, ``"+x"``, ``"y"``.
        strength: In [m/s^2].
    """
    sign, axis = (direction[0], direction[1:]) if direction[:1] in "+-" else ("+", direction)
    if axis not in ("x", "y", "z"):
        remedy = "Use x, y or z with an optional sign, such as '-z'."
        raise InputError([Mistake("gravity", f"{direction!r} is not a direction.", remedy)])
    value = -1.0 if sign == "-" else 1.0
    x, y, z = (value if axis == name else 0.0 for name in "xyz")
    return Gravity((x, y, z), sympy.sympify(strength))


def limits(name: str, limit: Limit) -> tuple[float, float]:
    """Read a limit, a magnitude or a pair, as (lower, upper)."""
    lower, upper = limit if isinstance(limit, tuple) else (-limit, limit)
    if not (math.isfinite(lower) and math.isfinite(upper) and lower < upper):
        remedy = "Give a positive magnitude, or (lower, upper), finite."
        raise InputError([Mistake(f"input {name!r}", f"its limit is {limit!r}.", remedy)])
    return float(lower), float(upper)
