"""Rigid frames g(q) in SE(3) as products of elementary motions, and their body velocity.

A frame remembers how it was built, so that frames with a common beginning share its kinematics and
an axis keeps its identity: the coin's axle is the fork's y axis, whatever the coin's roll.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import sympy

from kinolab.dynamics.shapes import AxisName
from kinolab.dynamics.symbols import Coordinate, rate

Number: TypeAlias = int | float | sympy.Expr
Vector: TypeAlias = tuple[sympy.Expr, sympy.Expr, sympy.Expr]

AXES: dict[AxisName, int] = {"x": 0, "y": 1, "z": 2}


@dataclass(frozen=True)
class Translation:
    """A motion along the axes of the frame it starts from, in [m]."""

    by: Vector


@dataclass(frozen=True)
class Rotation:
    """A right-handed turn about one axis of the frame it starts from, in [rad]."""

    axis: AxisName
    angle: sympy.Expr


Motion: TypeAlias = Translation | Rotation


@dataclass(frozen=True)
class Frame:
    """A pose g(q), the product of its motions from left to right, starting at the world frame."""

    motions: tuple[Motion, ...] = ()

    def __matmul__(self, other: Frame) -> Frame:
        return Frame(self.motions + other.motions)

    @property
    def x(self) -> Axis:
        """The frame's x axis."""
        return Axis(self, "x")

    @property
    def y(self) -> Axis:
        """The frame's y axis."""
        return Axis(self, "y")

    @property
    def z(self) -> Axis:
        """The frame's z axis."""
        return Axis(self, "z")


@dataclass(frozen=True)
class Axis:
    """A unit direction that is fixed in a frame and moves with it."""

    frame: Frame
    name: AxisName


@dataclass(frozen=True)
class BodyVelocity:
    """unhat(g^-1 g_dot): the velocity of a frame's origin and its turn rate, in its own axes.

    ``x``, ``y``, ``z`` are linear in [m/s]; ``wx``, ``wy``, ``wz`` are angular in [rad/s].

    Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, 2.4.
    """

    x: sympy.Expr
    y: sympy.Expr
    z: sympy.Expr
    wx: sympy.Expr
    wy: sympy.Expr
    wz: sympy.Expr

    @property
    def linear(self) -> sympy.Matrix:
        """Velocity of the origin, a column of 3, in [m/s]."""
        return sympy.Matrix([self.x, self.y, self.z])

    @property
    def angular(self) -> sympy.Matrix:
        """Angular velocity, a column of 3, in [rad/s]."""
        return sympy.Matrix([self.wx, self.wy, self.wz])


WORLD = Frame()


def move(x: Number = 0, y: Number = 0, z: Number = 0) -> Frame:
    """Return a frame displaced by (x, y, z) in [m] along the axes it is multiplied to."""
    return Frame((Translation((sympy.sympify(x), sympy.sympify(y), sympy.sympify(z))),))


def rot_x(angle: Number) -> Frame:
    """Return a frame turned about the x axis by ``angle`` in [rad], right-handed."""
    return Frame((Rotation("x", sympy.sympify(angle)),))


def rot_y(angle: Number) -> Frame:
    """Return a frame turned about the y axis by ``angle`` in [rad], right-handed."""
    return Frame((Rotation("y", sympy.sympify(angle)),))


def rot_z(angle: Number) -> Frame:
    """Return a frame turned about the z axis by ``angle`` in [rad], right-handed."""
    return Frame((Rotation("z", sympy.sympify(angle)),))


def time_derivative(expression: sympy.Expr) -> sympy.Expr:
    """Differentiate a function of coordinates along their rates (chain rule)."""
    terms = [
        sympy.diff(expression, symbol) * rate(symbol)
        for symbol in sorted(expression.free_symbols, key=str)
        if isinstance(symbol, Coordinate)
    ]
    return sympy.Add(*terms)


def velocity(frame: Frame) -> BodyVelocity:
    """Return the body velocity of a frame, as expressions in coordinates and rates."""
    linear, angular = _velocity(frame.motions)
    return BodyVelocity(*linear, *angular)


def rotation_matrix(axis: AxisName, angle: sympy.Expr) -> sympy.Matrix:
    """Return the 3x3 matrix of a right-handed turn about one axis."""
    i = AXES[axis]
    j, k = (i + 1) % 3, (i + 2) % 3
    matrix = sympy.eye(3)
    matrix[j, j] = matrix[k, k] = sympy.cos(angle)
    matrix[j, k], matrix[k, j] = -sympy.sin(angle), sympy.sin(angle)
    return matrix


@lru_cache(maxsize=1024)
def pose(frame: Frame) -> tuple[sympy.ImmutableMatrix, sympy.ImmutableMatrix]:
    """Return the rotation matrix (3x3) and the position (3x1, [m]) of a frame in the world."""
    R, p = sympy.eye(3), sympy.zeros(3, 1)
    for motion in frame.motions:
        if isinstance(motion, Translation):
            p = p + R * sympy.Matrix(motion.by)
        else:
            R = R * rotation_matrix(motion.axis, motion.angle)
    return sympy.ImmutableMatrix(R), sympy.ImmutableMatrix(p)


@lru_cache(maxsize=1024)
def _velocity(motions: tuple[Motion, ...]) -> tuple[sympy.ImmutableMatrix, sympy.ImmutableMatrix]:
    if not motions:
        zero = sympy.ImmutableMatrix([0, 0, 0])
        return zero, zero
    linear, angular = _velocity(motions[:-1])
    motion = motions[-1]
    if isinstance(motion, Translation):
        arm = sympy.Matrix(motion.by)
        return sympy.ImmutableMatrix(
            linear + angular.cross(arm) + arm.applyfunc(time_derivative)
        ), angular
    turn = rotation_matrix(motion.axis, motion.angle).T
    spin = sympy.zeros(3, 1)
    spin[AXES[motion.axis]] = time_derivative(motion.angle)
    return sympy.ImmutableMatrix(turn * linear), sympy.ImmutableMatrix(turn * angular + spin)
