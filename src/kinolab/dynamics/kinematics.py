"""Poses, velocities and accelerations of frames on a tape, shared between frames of one branch.

Motions are followed outward from the world, as in the recursive Newton-Euler algorithm: every
quantity of a frame follows from that of the frame before its last motion.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from kinolab.dynamics.frames import AXES, Axis, Frame, Motion, Rotation, Translation
from kinolab.dynamics.lowering import Lowering
from kinolab.dynamics.shapes import AxisName
from kinolab.dynamics.tape import Node, Tape

Vector: TypeAlias = tuple[Node, Node, Node]
Matrix3: TypeAlias = tuple[Vector, Vector, Vector]  # rows


@dataclass(frozen=True)
class Twist:
    """A linear and an angular vector in a frame's own axes."""

    linear: Vector
    angular: Vector


@dataclass(frozen=True)
class FrameState:
    """Everything the equations of motion need to know of one frame.

    Attributes:
        rotation: World from frame.
        position: Of the origin, in the world.
        velocity: Of the origin, and the turn rate, in the frame's axes.
        acceleration: Inertial acceleration of the origin, and angular acceleration, in the
            frame's axes, for the accelerations the kinematics were given.
        columns: The velocity caused by each direction of motion alone.
    """

    rotation: Matrix3
    position: Vector
    velocity: Twist
    acceleration: Twist
    columns: tuple[Twist, ...]


@dataclass(frozen=True)
class Motions:
    """The motion along which frames are followed; all lists have one entry per coordinate.

    Attributes:
        coordinates: Variable nodes.
        symbols: Variable nodes that stand for the rates inside derivatives.
        rates: What the rates are.
        accelerations: What the second derivatives are, free accelerations left at zero.
        directions: The directions of motion, each a rate per coordinate.
        base: Linear acceleration of the world frame; -g makes gravity part of the inertia forces.
    """

    coordinates: Sequence[Node]
    symbols: Sequence[Node]
    rates: Sequence[Node]
    accelerations: Sequence[Node]
    directions: Sequence[Sequence[Node]]
    base: Vector


class Kinematics:
    """Follows frames along given motions; frames with a common beginning are computed once."""

    def __init__(self, lower: Lowering, motions: Motions) -> None:
        self.lower, self.tape, self.motions = lower, lower.tape, motions
        zero, one = self.tape.zero, self.tape.one
        still = Twist((zero,) * 3, (zero,) * 3)
        self._states: dict[tuple[Motion, ...], FrameState] = {
            (): FrameState(
                rotation=((one, zero, zero), (zero, one, zero), (zero, zero, one)),
                position=(zero, zero, zero),
                velocity=still,
                acceleration=Twist(motions.base, (zero,) * 3),
                columns=(still,) * len(motions.directions),
            )
        }

    def __call__(self, frame: Frame) -> FrameState:
        """Return the state of a frame."""
        return self._follow(frame.motions)

    def direction(self, axis: Axis, seen_from: Frame) -> Vector:
        """Return a frame's axis in the axes of another frame.

        Only the motions after the common beginning count, so that the fork's axle is exactly the
        coin's y axis whatever the coin's roll.
        """
        own, other = axis.frame.motions, seen_from.motions
        shared = 0
        while shared < min(len(own), len(other)) and own[shared] == other[shared]:
            shared += 1
        vector = unit(self.tape, axis.name)
        for motion in reversed(own[shared:]):
            if isinstance(motion, Rotation):
                vector = turn(self.tape, motion.axis, self.lower(motion.angle), vector, 1)
        for motion in other[shared:]:
            if isinstance(motion, Rotation):
                vector = turn(self.tape, motion.axis, self.lower(motion.angle), vector, -1)
        return vector

    def _follow(self, motions: tuple[Motion, ...]) -> FrameState:
        state = self._states.get(motions)
        if state is None:
            before = self._follow(motions[:-1])
            last = motions[-1]
            state = (
                self._translate(before, last)
                if isinstance(last, Translation)
                else self._rotate(before, last)
            )
            self._states[motions] = state
        return state

    def _translate(self, before: FrameState, motion: Translation) -> FrameState:
        tape = self.tape
        arm: Vector = _vector([self.lower(component) for component in motion.by])
        speed, bias = self._moving(arm)
        spin, linear = before.velocity.angular, before.velocity.linear
        centripetal = cross(tape, spin, cross(tape, spin, arm))
        coriolis = scale(tape, tape.constant(2.0), cross(tape, spin, speed))
        swing = cross(tape, before.acceleration.angular, arm)
        acceleration = add(tape, before.acceleration.linear, swing, centripetal, coriolis, bias)
        return FrameState(
            rotation=before.rotation,
            position=add(tape, before.position, transform(tape, before.rotation, arm)),
            velocity=Twist(add(tape, linear, cross(tape, spin, arm), speed), spin),
            acceleration=Twist(acceleration, before.acceleration.angular),
            columns=tuple(
                Twist(
                    add(
                        tape,
                        column.linear,
                        cross(tape, column.angular, arm),
                        self._along(arm, direction),
                    ),
                    column.angular,
                )
                for column, direction in zip(before.columns, self.motions.directions, strict=True)
            ),
        )

    def _rotate(self, before: FrameState, motion: Rotation) -> FrameState:
        tape = self.tape
        angle = self.lower(motion.angle)
        axis = unit(tape, motion.axis)
        (speed, _, _), (bias, _, _) = self._moving((angle, tape.zero, tape.zero))

        def back(vector: Vector) -> Vector:
            return turn(tape, motion.axis, angle, vector, -1)

        carried = back(before.velocity.angular)
        gyration = cross(tape, carried, scale(tape, speed, axis))
        angular = add(tape, back(before.acceleration.angular), gyration, scale(tape, bias, axis))
        columns = []
        for column, direction in zip(before.columns, self.motions.directions, strict=True):
            share, _, _ = self._along((angle, tape.zero, tape.zero), direction)
            spin = add(tape, back(column.angular), scale(tape, share, axis))
            columns.append(Twist(back(column.linear), spin))
        return FrameState(
            rotation=_vector3([turn(tape, motion.axis, angle, row, -1) for row in before.rotation]),
            position=before.position,
            velocity=Twist(
                back(before.velocity.linear), add(tape, carried, scale(tape, speed, axis))
            ),
            acceleration=Twist(back(before.acceleration.linear), angular),
            columns=tuple(columns),
        )

    def _moving(self, values: Vector) -> tuple[Vector, Vector]:
        """Return the first and second time derivative of three functions of the coordinates."""
        tape, motions = self.tape, self.motions
        along = dict(zip(motions.coordinates, motions.symbols, strict=True))
        first = tape.derivative(values, along)
        curvature = tape.derivative(first, along)
        actual = dict(zip(motions.symbols, motions.rates, strict=True))
        speed, bend = tape.substitute(first, actual), tape.substitute(curvature, actual)
        push = self._along(values, motions.accelerations)
        return _vector(speed), add(tape, _vector(bend), push)

    def _along(self, values: Vector, direction: Sequence[Node]) -> Vector:
        seeds = dict(zip(self.motions.coordinates, direction, strict=True))
        return _vector(self.tape.derivative(values, seeds))


def unit(tape: Tape, axis: AxisName) -> Vector:
    """Return a unit vector along an axis."""
    return _vector([tape.one if name == axis else tape.zero for name in AXES])


def add(tape: Tape, *vectors: Vector) -> Vector:
    """Return the sum of vectors."""
    return _vector([tape.sum(components) for components in zip(*vectors, strict=True)])


def scale(tape: Tape, factor: Node, vector: Vector) -> Vector:
    """Return a multiple of a vector."""
    return _vector([tape.mul(factor, component) for component in vector])


def cross(tape: Tape, a: Vector, b: Vector) -> Vector:
    """Return the vector product a x b."""
    return _vector(
        [tape.sub(tape.mul(a[j], b[k]), tape.mul(a[k], b[j])) for j, k in ((1, 2), (2, 0), (0, 1))]
    )


def transform(tape: Tape, matrix: Matrix3, vector: Vector) -> Vector:
    """Return the product of a 3x3 matrix and a vector."""
    return _vector([tape.dot(row, vector) for row in matrix])


def turn(tape: Tape, axis: AxisName, angle: Node, vector: Vector, sign: int) -> Vector:
    """Turn a vector about an axis by the angle (sign 1) or back (sign -1)."""
    i = AXES[axis]
    j, k = (i + 1) % 3, (i + 2) % 3
    c, s = tape.unary("cos", angle), tape.unary("sin", angle)
    s = s if sign > 0 else tape.neg(s)
    turned = list(vector)
    turned[j] = tape.sub(tape.mul(c, vector[j]), tape.mul(s, vector[k]))
    turned[k] = tape.add(tape.mul(s, vector[j]), tape.mul(c, vector[k]))
    return _vector(turned)


def _vector(values: Sequence[Node]) -> Vector:
    x, y, z = values
    return x, y, z


def _vector3(rows: Sequence[Vector]) -> Matrix3:
    x, y, z = rows
    return x, y, z
