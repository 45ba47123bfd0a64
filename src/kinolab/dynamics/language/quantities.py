"""Quantities of frames that forces act along: each derivation has its own kinematics for them.

A place along a chain of frames is long as a formula in coordinates, and short as a symbol. So a
force's energy or magnitude may hold such symbols, and its load may act along a speed of a frame;
``written`` puts formulas in their places.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.frames import (
    AXES,
    Axis,
    Frame,
    Number,
    pose,
    relative_pose,
    time_derivative,
    velocity,
)
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import MachineSymbol

UP = sympy.symbols("up_x up_y up_z", real=True)  # unit vector against gravity, in the world


class FrameQuantity(MachineSymbol):
    """A symbol that stands for a function of frames."""

    @property
    def formula(self) -> sympy.Expr:
        """What it is in coordinates and rates."""
        raise NotImplementedError


class Place(FrameQuantity):
    """A coordinate of a frame's origin in the world in [m]: 0 for x, 1 for y, 2 for z."""

    def __new__(cls, frame: Frame, entry: int) -> Place:
        """Make the symbol of a frame."""
        return cls._build(f"{'xyz'[entry]} of {frame}", (frame, entry))

    @property
    def formula(self) -> sympy.Expr:
        """What it is in coordinates."""
        frame, entry = self.facts
        return pose(frame)[1][entry]


@checked
class Change(FrameQuantity):
    """The time derivative of a function of coordinates and places, its ``position``."""

    position: sympy.Expr

    def __new__(cls, position: sympy.Expr) -> Change:
        """Make the symbol of a position."""
        return cls._build(f"d({position})/dt", (position,))

    @property
    def formula(self) -> sympy.Expr:
        """What it is in coordinates and rates."""
        return time_derivative(written(self.position))


@checked
@dataclass(frozen=True)
class FrameSpeed:
    """The velocity of a point that moves with a frame along an axis, or its turning about it.

    Attributes:
        on: The frame that moves.
        axis: The axis.
        at: The frame at whose origin the point is now; None of an angular velocity, in [rad/s].
    """

    on: Frame
    axis: Axis
    at: Frame | None = None

    @property
    def formula(self) -> sympy.Expr:
        """What it is in coordinates and rates."""
        V = velocity(self.on)
        axis = relative_pose(self.axis.frame, self.on)[0][:, AXES[self.axis.name]]
        if self.at is None:
            return axis.dot(V.angular)
        return axis.dot(V.linear + V.angular.cross(relative_pose(self.at, self.on)[1]))


@checked
def place(frame: Frame) -> sympy.Matrix:
    """Return the origin of a frame in the world in [m], as a column of symbols."""
    return sympy.Matrix([Place(frame, entry) for entry in range(3)])


@checked
def apart(first: Frame, second: Frame) -> sympy.Expr:
    """Return how far the origins of two frames are apart in [m], by the symbols of their places."""
    path = place(second) - place(first)
    return sympy.sqrt(path.dot(path))


def written(quantity: Number | FrameSpeed) -> sympy.Expr:
    """Return an expression, or a speed of a frame, in coordinates and rates alone."""
    if isinstance(quantity, FrameSpeed):
        return quantity.formula
    stated = exact(quantity)
    return stated.xreplace({one: one.formula for one in stated.atoms(FrameQuantity)})


def frames_in(quantity: Number | FrameSpeed) -> Iterator[Frame]:
    """Yield the frames that an expression's quantities, or a speed of a frame, are of."""
    if isinstance(quantity, FrameSpeed):
        yield from (quantity.on, quantity.axis.frame, quantity.at or quantity.on)
        return
    for symbol in sorted(exact(quantity).atoms(FrameQuantity), key=str):
        first = symbol.facts[0]
        yield from (first,) if isinstance(first, Frame) else frames_in(first)
