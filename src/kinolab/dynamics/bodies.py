"""Rigid bodies: where they are, what they weigh, and what they look like."""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from kinolab.dynamics.frames import Frame, Number
from kinolab.dynamics.shapes import Shape


@dataclass(frozen=True, init=False)
class Body:
    """A rigid body whose centre of mass is the origin of its frame.

    Args:
        name: What contacts, goals and pictures call it.
        frame: Pose of the centre of mass.
        mass: In [kg].
        inertia: Principal moments about the centre of mass along the frame's axes, in [kg m^2];
            0 for a point mass.
        shape: One solid or several, in the body's frame; none for a body that is only mass.
        touches_ground: Whether the ground carries it (wheels, feet); it may touch, not sink.
        color: Red, green and blue in [0, 1]; chosen from a palette when left out.
    """

    name: str
    frame: Frame
    mass: sympy.Expr
    inertia: tuple[sympy.Expr, sympy.Expr, sympy.Expr]
    shapes: tuple[Shape, ...]
    touches_ground: bool
    color: tuple[float, float, float] | None

    def __init__(
        self,
        name: str,
        frame: Frame,
        *,
        mass: Number = 0,
        inertia: Number | tuple[Number, Number, Number] = 0,
        shape: Shape | tuple[Shape, ...] | None = None,
        touches_ground: bool = False,
        color: tuple[float, float, float] | None = None,
    ) -> None:
        moments = inertia if isinstance(inertia, tuple) else (inertia, inertia, inertia)
        shapes = shape if isinstance(shape, tuple) else () if shape is None else (shape,)
        fields = {
            "name": name,
            "frame": frame,
            "mass": sympy.sympify(mass),
            "inertia": tuple(sympy.sympify(moment) for moment in moments),
            "shapes": shapes,
            "touches_ground": touches_ground,
            "color": color,
        }
        for field, value in fields.items():
            object.__setattr__(self, field, value)
