"""Quantities of frames that forces act along: each derivation has its own kinematics for them.

The distance between two chains of frames is long as a formula in coordinates, and short as a
symbol. So a force's energy or magnitude may hold such symbols, and its load may act along a speed
of a frame; ``written`` puts formulas in their places.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.expressions import exact
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
from kinolab.dynamics.language.symbols import MachineSymbol

Up: TypeAlias = tuple[float, float, float]
SKYWARD: Up = (0.0, 0.0, 1.0)  # where a machine has no gravity


class FrameQuantity(MachineSymbol):
    """A symbol that stands for a function of frames."""

    __slots__ = ()

    def formula(self, up: Up) -> sympy.Expr:
        """Return it in coordinates and rates; ``up`` is a unit vector against gravity."""
        raise NotImplementedError(up)


class SquaredDistance(FrameQuantity):
    """The squared distance of the origins of two frames in [m^2]: smooth where they meet."""

    __slots__ = ()

    def __new__(cls, first: Frame, second: Frame) -> SquaredDistance:
        """Make the symbol of two frames."""
        made: SquaredDistance = cls._build(f"distance({first}, {second})**2", (first, second))
        return made

    @property
    def between(self) -> tuple[Frame, Frame]:
        """The two frames."""
        first, second = self.facts
        return first, second

    def formula(self, _: Up) -> sympy.Expr:
        """Return it in coordinates."""
        first, second = self.between
        path = pose(second)[1] - pose(first)[1]
        return path.dot(path)


class Height(FrameQuantity):
    """How high the origin of a frame is in [m], against gravity; along z where there is none."""

    __slots__ = ()

    def __new__(cls, frame: Frame) -> Height:
        """Make the symbol of a frame."""
        made: Height = cls._build(f"height({frame})", (frame,))
        return made

    @property
    def frame(self) -> Frame:
        """The frame."""
        frame: Frame = self.facts[0]
        return frame

    def formula(self, up: Up) -> sympy.Expr:
        """Return it in coordinates."""
        return sympy.Matrix(list(map(sympy.nsimplify, up))).dot(pose(self.frame)[1])


class Change(FrameQuantity):
    """The time derivative of a function of coordinates, distances and heights."""

    __slots__ = ()

    def __new__(cls, position: sympy.Expr) -> Change:
        """Make the symbol of a position."""
        made: Change = cls._build(f"d({position})/dt", (position,))
        return made

    @property
    def position(self) -> sympy.Expr:
        """What is differentiated."""
        return self.facts[0]

    def formula(self, up: Up) -> sympy.Expr:
        """Return it in coordinates and rates."""
        return time_derivative(written(self.position, up))


@checked
@dataclass(frozen=True)
class PointSpeed:
    """The velocity along an axis of a point that moves with a frame.

    Attributes:
        on: The frame with which the point moves.
        along: The axis.
        at: The frame at whose origin the point is now.
    """

    on: Frame
    along: Axis
    at: Frame

    @property
    def formula(self) -> sympy.Expr:
        """It in coordinates and rates, in [m/s]."""
        V, arm = velocity(self.on), relative_pose(self.at, self.on)[1]
        return _direction(self.along, self.on).dot(V.linear + V.angular.cross(arm))


@checked
@dataclass(frozen=True)
class TurnSpeed:
    """The angular velocity of a frame about an axis.

    Attributes:
        on: The frame that turns.
        about: The axis.
    """

    on: Frame
    about: Axis

    @property
    def formula(self) -> sympy.Expr:
        """It in coordinates and rates, in [rad/s]."""
        return _direction(self.about, self.on).dot(velocity(self.on).angular)


FrameSpeed: TypeAlias = PointSpeed | TurnSpeed


def apart(first: Frame, second: Frame) -> sympy.Expr:
    """Return how far the origins of two frames are apart in [m], by the symbol of its square."""
    return sympy.sqrt(SquaredDistance(first, second))


def written(quantity: Number | FrameSpeed, up: Up = SKYWARD) -> sympy.Expr:
    """Return an expression, or a speed of a frame, in coordinates and rates alone."""
    if isinstance(quantity, FrameSpeed):
        return quantity.formula
    stated = exact(quantity)
    return stated.xreplace({one: one.formula(up) for one in stated.atoms(FrameQuantity)})


def frames_in(quantity: Number | FrameSpeed) -> Iterator[Frame]:
    """Yield the frames that an expression's quantities, or a speed of a frame, are of."""
    if isinstance(quantity, FrameSpeed):
        axis = quantity.along if isinstance(quantity, PointSpeed) else quantity.about
        yield from (quantity.on, axis.frame, getattr(quantity, "at", quantity.on))
        return
    for symbol in sorted(exact(quantity).atoms(FrameQuantity), key=str):
        for fact in symbol.facts:
            yield from (fact,) if isinstance(fact, Frame) else frames_in(fact)


def _direction(axis: Axis, seen_from: Frame) -> sympy.Matrix:
    """Express a frame's axis in another frame's axes."""
    return relative_pose(axis.frame, seen_from)[0][:, AXES[axis.name]]
