"""Frames g(q) in SE(3) as products of elementary motions, and their body velocities.

A frame stores its chain of motions, so that frames with a common prefix share its kinematics and an
axis keeps its identity: the coin's axle is the fork's y axis, whatever the coin's roll.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import takewhile
from math import comb
from typing import NoReturn, TypeAlias

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.shapes import AxisName
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.slips import slipped
from kinolab.dynamics.symbols.symbols import Attitude, Coordinate, QuaternionEntry, rate
from kinolab.errors import InputError, Mistake, UnknownNameError

Number: TypeAlias = int | float | sympy.Expr
Vector: TypeAlias = tuple[sympy.Expr, sympy.Expr, sympy.Expr]
Quaternion: TypeAlias = tuple[Number, Number, Number, Number]

AXES: dict[AxisName, int] = {"x": 0, "y": 1, "z": 2}
# Of half the angle, at most pi / 2, an eighth is at most pi / 16 = 0.2, and 1 - cos of that 0.02:
# eight terms leave 3e-18 of the sum of all.
HALVINGS, TERMS = 3, 8


def check_axis(name: str) -> None:
    """Raise unless the name is that of an axis.

    Raises:
        UnknownNameError: If it is not x, y or z.
    """
    if name not in AXES:
        raise UnknownNameError("axis", str(name), known=AXES)


@checked
@dataclass(frozen=True)
class Translation:
    """A translation along the axes of the previous frame, in [m]."""

    by: Vector

    @property
    def entries(self) -> Sequence[sympy.Expr]:
        """What it depends on."""
        return self.by


@checked
@dataclass(frozen=True)
class Rotation:
    """A right-handed rotation about one axis of the previous frame, in [rad]."""

    axis: AxisName
    angle: sympy.Expr

    def __post_init__(self) -> None:
        """Validate the axis."""
        check_axis(self.axis)

    @property
    def entries(self) -> Sequence[sympy.Expr]:
        """What it depends on."""
        return (self.angle,)


@checked
@dataclass(frozen=True)
class Orientation:
    """A rotation by an attitude coordinate."""

    attitude: Attitude

    @property
    def entries(self) -> Sequence[sympy.Expr]:
        """What it depends on."""
        return self.attitude.quaternion


Motion: TypeAlias = Translation | Rotation | Orientation


@checked
@dataclass(frozen=True)
class Frame:
    """A pose g(q), the product of its motions from left to right, starting at the world frame."""

    motions: tuple[Motion, ...] = ()

    def __matmul__(self, other: Frame) -> Frame:
        return Frame(self.motions + _frame(other).motions)

    def __rmatmul__(self, other: object) -> Frame:
        return _frame(other) @ self

    def _no_number(self, _: object) -> NoReturn:
        what = "frames are neither numbers nor arrays."
        slipped(
            "Frame", what, "The product of two is first @ second, as in move(x, y) @ rot_z(psi)."
        )

    __mul__ = __rmul__ = __add__ = __radd__ = __sub__ = __rsub__ = __pow__ = _no_number
    __array_ufunc__ = None  # NumPy asks the frame, too

    def after(self, other: Frame) -> tuple[Motion, ...]:
        """Return the motions after those with which another frame begins alike."""
        pairs = zip(self.motions, other.motions, strict=False)
        alike = takewhile(lambda pair: pair[0] == pair[1], pairs)
        return self.motions[sum(1 for _ in alike) :]

    @property
    def moves(self) -> bool:
        """Whether the pose depends on a coordinate."""
        return any(movers_of(motion) for motion in self.motions)

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


def movers_of(motion: Motion) -> list[Coordinate | Attitude]:
    """Return the coordinates that a motion depends on, in the order of their creation."""
    atoms = {a for e in motion.entries for a in exact(e).atoms(Coordinate, QuaternionEntry)}
    movers = {a.attitude if isinstance(a, QuaternionEntry) else a for a in atoms}
    return sorted(movers, key=lambda mover: mover.serial)


def _frame(factor: object) -> Frame:
    """Return a factor of a product of frames; raise if it is no frame."""
    if not isinstance(factor, Frame):
        remedy = "Give a frame, such as move(x, y) @ rot_z(psi)."
        raise InputError([Mistake("Frame @", f"it is {factor!r}.", remedy)])
    return factor


@checked
@dataclass(frozen=True)
class Axis:
    """A unit vector along an axis of a frame, with which it moves.

    Attributes:
        frame: The frame.
        name: ``x``, ``y`` or ``z``.
    """

    frame: Frame
    name: AxisName

    def __post_init__(self) -> None:
        """Validate the axis."""
        check_axis(self.name)

    def __neg__(self) -> Axis:
        """Return the opposite direction, as an axis of the same frame turned by half a turn."""
        turned = self.frame @ (rot_z(sympy.pi) if self.name == "x" else rot_x(sympy.pi))
        return Axis(turned, self.name)


@checked
@dataclass(frozen=True)
class BodyVelocity:
    """Body velocity unhat(g^-1 g_dot): linear (of the origin) and angular, in the frame's axes.

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


@checked
def hat(twist: Sequence[Number]) -> sympy.Matrix:
    """Return a twist (vx, vy, vz, wx, wy, wz) as the 4x4 matrix of se(3).

    Raises:
        InputError: If it does not have six entries.

    Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, 2.3.
    """
    if len(twist) != 6:
        raise InputError([Mistake("hat twist", f"it has {len(twist)} numbers.", "Give six.")])
    vx, vy, vz, wx, wy, wz = twist
    return sympy.Matrix([[0, -wz, wy, vx], [wz, 0, -wx, vy], [-wy, wx, 0, vz], [0, 0, 0, 0]])


@checked
def unhat(matrix: sympy.Matrix) -> BodyVelocity:
    """Return the twist of a 4x4 matrix of se(3), such as g^-1 g_dot."""
    if matrix.shape != (4, 4):
        what = f"it is {matrix.rows}x{matrix.cols}."
        raise InputError([Mistake("unhat matrix", what, "Give a 4x4 matrix.")])
    vx, vy, vz = (matrix[i, 3] for i in range(3))
    return BodyVelocity(vx, vy, vz, matrix[2, 1], matrix[0, 2], matrix[1, 0])


@checked
def homogeneous(frame: Frame) -> sympy.Matrix:
    """Return a frame as a 4x4 matrix; one of only move(x, y) and rot_z is in SE(2)."""
    R, p = pose(frame)
    return sympy.Matrix.vstack(sympy.Matrix.hstack(R, p), sympy.Matrix([[0, 0, 0, 1]]))


WORLD = Frame()


@checked
def move(x: Number = 0, y: Number = 0, z: Number = 0) -> Frame:
    """Return a frame translated by (x, y, z) in [m] along the axes of its left factor."""
    return Frame((Translation((exact(x), exact(y), exact(z))),))


@checked
def rot_x(angle: Number) -> Frame:
    """Return a frame rotated about the x axis by ``angle`` in [rad], right-handed."""
    return Frame((Rotation("x", exact(angle)),))


@checked
def rot_y(angle: Number) -> Frame:
    """Return a frame rotated about the y axis by ``angle`` in [rad], right-handed."""
    return Frame((Rotation("y", exact(angle)),))


@checked
def rot_z(angle: Number) -> Frame:
    """Return a frame rotated about the z axis by ``angle`` in [rad], right-handed."""
    return Frame((Rotation("z", exact(angle)),))


@checked
def orient(attitude: Attitude) -> Frame:
    """Return a frame rotated by an attitude from ``rotation``."""
    return Frame((Orientation(attitude),))


def time_derivative(expression: sympy.Expr) -> sympy.Expr:
    """Differentiate a function of coordinates along their rates (chain rule)."""
    terms = [
        sympy.diff(expression, symbol) * motion_of(symbol)
        for symbol in sorted(expression.free_symbols, key=str)
        if isinstance(symbol, Coordinate | QuaternionEntry)
    ]
    return sympy.Add(*terms)


def motion_of(symbol: Coordinate | QuaternionEntry) -> sympy.Expr:
    """Return the time derivative of an entry of the configuration.

    A quaternion q changes by q_dot = 1/2 q * (omega, 0), omega in body axes.

    Source: Diebel, Representing Attitude, Stanford 2006, section 6.
    """
    if isinstance(symbol, Coordinate):
        return rate(symbol)
    x, y, z, w = symbol.attitude.quaternion
    a, b, c = symbol.attitude.turn_rate
    changes = (
        w * a + y * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - y * a,
        -x * a - y * b - z * c,
    )
    return changes[symbol.index] / 2


@checked
def velocity(frame: Frame) -> BodyVelocity:
    """Return the body velocity of a frame, as expressions in coordinates and rates."""
    linear, angular = _velocity(frame.motions)
    return BodyVelocity(*linear, *angular)


def rotation_matrix(axis: AxisName, angle: sympy.Expr) -> sympy.Matrix:
    """Return the 3x3 matrix of a right-handed rotation about one axis."""
    i = AXES[axis]
    j, k = (i + 1) % 3, (i + 2) % 3
    matrix = sympy.eye(3)
    matrix[j, j] = matrix[k, k] = sympy.cos(angle)
    matrix[j, k], matrix[k, j] = -sympy.sin(angle), sympy.sin(angle)
    return matrix


def attitude_matrix(attitude: Attitude) -> sympy.Matrix:
    """Return the 3x3 rotation matrix of an attitude, orthogonal even where |q| is not 1."""
    x, y, z, w = attitude.quaternion
    square = x**2 + y**2 + z**2 + w**2
    rows = [
        [w**2 + x**2 - y**2 - z**2, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w**2 - x**2 + y**2 - z**2, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w**2 - x**2 - y**2 + z**2],
    ]
    return sympy.Matrix(rows) / square


def turn_matrix(motion: Rotation | Orientation) -> sympy.Matrix:
    """Return the 3x3 rotation matrix of a motion."""
    if isinstance(motion, Rotation):
        return rotation_matrix(motion.axis, motion.angle)
    return attitude_matrix(motion.attitude)


@lru_cache(maxsize=1024)
def pose(frame: Frame) -> tuple[sympy.ImmutableMatrix, sympy.ImmutableMatrix]:
    """Return the rotation matrix (3x3) and the position (3x1, [m]) of a frame in the world."""
    R, p = sympy.eye(3), sympy.zeros(3, 1)
    for motion in frame.motions:
        if isinstance(motion, Translation):
            p = p + R * sympy.Matrix(motion.by)
        else:
            R = R * turn_matrix(motion)
    return sympy.ImmutableMatrix(R), sympy.ImmutableMatrix(p)


@lru_cache(maxsize=1024)
def relative_pose(
    frame: Frame, seen_from: Frame
) -> tuple[sympy.ImmutableMatrix, sympy.ImmutableMatrix]:
    """Return a frame's rotation matrix and position in another frame's axes, as ``pose`` does.

    The common part of both chains is left out: a coin's axle is its own y axis whatever its roll.
    """
    (R, p), (S, o) = pose(Frame(frame.after(seen_from))), pose(Frame(seen_from.after(frame)))
    return S.T * R, S.T * (p - o)


def distance(first: Frame, second: Frame) -> sympy.Expr:
    """Return how far the origins of two frames are apart in [m]."""
    path = pose(second)[1] - pose(first)[1]
    return sympy.sqrt(path.dot(path))


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
    turn = turn_matrix(motion).T
    spin = sympy.zeros(3, 1)
    if isinstance(motion, Rotation):
        spin[AXES[motion.axis]] = time_derivative(motion.angle)
    else:
        spin = sympy.Matrix(motion.attitude.turn_rate)
    return sympy.ImmutableMatrix(turn * linear), sympy.ImmutableMatrix(turn * angular + spin)


@checked
def squared_turn(attitude: Attitude, rest: Quaternion = (0, 0, 0, 1)) -> sympy.Expr:
    """Return the square of the angle in [rad] by which an attitude is turned from another one.

    The angle is that about a single axis, at most pi. Half the stiffness times this is the energy
    of a ball joint's spring: its torque is along that axis, and reverses at half a turn.

    Args:
        attitude: The attitude.
        rest: A unit quaternion x, y, z, w, from which it is turned.

    Source: Gradshteyn, Ryzhik, Table of Integrals, Series, and Products, 1.645 (arcsin^2).
    """
    entries = attitude.quaternion
    along = sympy.Add(*(exact(r) * q for r, q in zip(rest, entries, strict=True)))
    cosine = sympy.Abs(along) / sympy.sqrt(sympy.Add(*(q**2 for q in entries)))  # of half the angle
    for _ in range(HALVINGS):
        cosine = sympy.sqrt((1 + cosine) / 2)
    # arccos(c)^2 = 2 sum of x^n / (n^2 (2n over n)), with x = 2 (1 - c); by Horner's rule
    x, total = 2 * (1 - cosine), sympy.Integer(0)
    for n in range(TERMS, 0, -1):
        total = x * (sympy.Rational(2, n**2 * comb(2 * n, n)) + total)
    return 4 ** (HALVINGS + 1) * total
