"""Forward kinematics of frames: poses, velocities, accelerations as expression graph nodes.

Recursion goes outward from the world, as in the recursive Newton-Euler algorithm: every
quantity of a frame follows from that of the frame before its last motion, shared along a branch.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 5.
"""

from __future__ import annotations

from dataclasses import dataclass

from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.derivation.vectors import Matrix3, Vector, Vectors
from kinolab.dynamics.derivation.velocity_coordinates import VelocityCoordinates
from kinolab.dynamics.language.frames import (
    Axis,
    Frame,
    Motion,
    Orientation,
    Rotation,
    Translation,
    attitude_matrix,
)


@dataclass(frozen=True)
class Twist:
    """A linear and an angular vector in a frame's axes."""

    linear: Vector
    angular: Vector


@dataclass(frozen=True)
class FrameState:
    """The kinematic state of one frame.

    Attributes:
        rotation: World from frame.
        position: Of the origin, in the world.
        velocity: Of the origin, and angular, in the frame's axes.
        acceleration: Of the origin in inertial space, and angular, in the frame's axes.
        columns: Columns of the body Jacobian, one twist per direction of motion.
    """

    rotation: Matrix3
    position: Vector
    velocity: Twist
    acceleration: Twist
    columns: tuple[Twist, ...]


class Kinematics:
    """Forward kinematics along given motions; common chains of frames are computed once.

    Args:
        motions: The velocities, their derivatives where free ones are zero, and the directions.
    """

    def __init__(self, binding: SymbolTable, motions: VelocityCoordinates) -> None:
        self.binding, self.motions = binding, motions
        self.tape, self.lower = binding.tape, binding.lower
        self.vectors = Vectors(binding.tape)
        self._flow = binding.flow()
        self._actual = binding.at(motions.velocities)
        self._seeds = [binding.flow(direction) for direction in motions.directions]
        self._pushed = binding.flow(motions.accelerations)
        still = Twist(self.vectors.zero, self.vectors.zero)
        self._states: dict[tuple[Motion, ...], FrameState] = {
            (): FrameState(
                rotation=self.vectors.identity,
                position=self.vectors.zero,
                velocity=still,
                acceleration=still,
                columns=(still,) * len(motions.directions),
            )
        }

    def __call__(self, frame: Frame) -> FrameState:
        """Return the state of a frame."""
        return self._follow(frame.motions)

    def direction(self, axis: Axis, seen_from: Frame) -> Vector:
        """Express a frame's axis in the axes of another frame.

        Only the motions after the common part of both chains count, so that the fork's axle is
        exactly the coin's y axis whatever the coin's roll.
        """
        unit = self.vectors.unit(axis.name)
        return self._carried(unit, axis.frame, seen_from, moved=False)

    def place(self, frame: Frame, seen_from: Frame) -> Vector:
        """Return where a frame's origin is in the axes of another frame, likewise."""
        return self._carried(self.vectors.zero, frame, seen_from, moved=True)

    def _carried(self, vector: Vector, own: Frame, seen_from: Frame, *, moved: bool) -> Vector:
        """Express a point, or a direction that translations do not move, in other axes."""
        for motion in reversed(own.after(seen_from)):
            if not isinstance(motion, Translation):
                vector = self._back(motion, vector, 1)
            elif moved:
                vector = self.vectors.add(self._arm(motion), vector)
        for motion in seen_from.after(own):
            if not isinstance(motion, Translation):
                vector = self._back(motion, vector)
            elif moved:
                vector = self.vectors.sub(vector, self._arm(motion))
        return vector

    def _arm(self, motion: Translation) -> Vector:
        return self.vectors.vector([self.lower(component) for component in motion.by])

    def _follow(self, motions: tuple[Motion, ...]) -> FrameState:
        known = next(k for k in range(len(motions), -1, -1) if motions[:k] in self._states)
        state = self._states[motions[:known]]
        for k, last in enumerate(motions[known:], start=known + 1):
            state = (
                self._translate(state, last)
                if isinstance(last, Translation)
                else self._turn(state, last)
            )
            self._states[motions[:k]] = state
        return state

    def _translate(self, before: FrameState, motion: Translation) -> FrameState:
        tape, vectors = self.tape, self.vectors
        arm = self._arm(motion)
        speed, bias = self._changes(arm)
        spin = before.velocity.angular
        centripetal = vectors.cross(spin, vectors.cross(spin, arm))
        coriolis = vectors.scale(tape.constant(2.0), vectors.cross(spin, speed))
        swing = vectors.cross(before.acceleration.angular, arm)
        acceleration = vectors.add(before.acceleration.linear, swing, centripetal, coriolis, bias)

        def carried(twist: Twist, own: Vector) -> Twist:
            lever = vectors.cross(twist.angular, arm)
            return Twist(vectors.add(twist.linear, lever, own), twist.angular)

        return FrameState(
            rotation=before.rotation,
            position=vectors.add(before.position, vectors.transform(before.rotation, arm)),
            velocity=carried(before.velocity, speed),
            acceleration=Twist(acceleration, before.acceleration.angular),
            columns=tuple(
                carried(column, vectors.vector(tape.derivative(arm, seeds)))
                for column, seeds in zip(before.columns, self._seeds, strict=True)
            ),
        )

    def _turn(self, before: FrameState, motion: Rotation | Orientation) -> FrameState:
        vectors = self.vectors
        spin, bias, shares = self._spin(motion)
        carried = self._back(motion, before.velocity.angular)
        angular = vectors.add(
            self._back(motion, before.acceleration.angular), vectors.cross(carried, spin), bias
        )
        a, b, c = (self._back(motion, row) for row in before.rotation)
        return FrameState(
            rotation=(a, b, c),
            position=before.position,
            velocity=Twist(self._back(motion, before.velocity.linear), vectors.add(carried, spin)),
            acceleration=Twist(self._back(motion, before.acceleration.linear), angular),
            columns=tuple(
                Twist(
                    self._back(motion, column.linear),
                    vectors.add(self._back(motion, column.angular), fraction),
                )
                for column, fraction in zip(before.columns, shares, strict=True)
            ),
        )

    def _spin(self, motion: Rotation | Orientation) -> tuple[Vector, Vector, list[Vector]]:
        """Return a rotation's angular velocity, its derivative, and its Jacobian columns."""
        tape, vectors, motions = self.tape, self.vectors, self.motions
        if isinstance(motion, Orientation):
            symbols = (self.lower(symbol) for symbol in motion.attitude.turn_rate)
            entries = [self.binding.tangent.index(symbol) for symbol in symbols]
            speed, push, *shares = (
                vectors.vector([values[entry] for entry in entries])
                for values in (motions.velocities, motions.accelerations, *motions.directions)
            )
            return speed, push, shares
        angle = self.lower(motion.angle)
        axis = vectors.unit(motion.axis)
        rate, bias = (values[0] for values in self._changes((angle, tape.zero, tape.zero)))
        return (
            vectors.scale(rate, axis),
            vectors.scale(bias, axis),
            [vectors.scale(tape.derivative([angle], seeds)[0], axis) for seeds in self._seeds],
        )

    def _changes(self, values: Vector) -> tuple[Vector, Vector]:
        """Return the first and second time derivatives of three functions of q."""
        tape, vectors = self.tape, self.vectors
        first = tape.derivative(values, self._flow)
        curvature = tape.derivative(first, self._flow)
        speed = vectors.vector(tape.substitute(first, self._actual))
        bend = vectors.vector(tape.substitute(curvature, self._actual))
        push = vectors.vector(tape.derivative(values, self._pushed))
        return speed, vectors.add(bend, push)

    def _back(self, motion: Rotation | Orientation, vector: Vector, sign: int = -1) -> Vector:
        """Rotate a vector by a motion's inverse, to the axes after it; by the motion for 1."""
        if isinstance(motion, Rotation):
            return self.vectors.turn(motion.axis, self.lower(motion.angle), vector, sign)
        matrix = self._matrix(motion)
        return self.vectors.transform(
            matrix if sign > 0 else self.vectors.transpose(matrix), vector
        )

    def _matrix(self, motion: Orientation) -> Matrix3:
        entries = attitude_matrix(motion.attitude)
        a, b, c = (
            self.vectors.vector([self.lower(entries[i, j]) for j in range(3)]) for i in range(3)
        )
        return a, b, c
