"""Potentials and loads, projected onto the directions of motion of a machine.

A force along a quantity of frames, such as the distance of two, is applied to these frames: its
slope by their places is a wrench on each, whose power with each direction is the force along it.
What is stated in coordinates and rates is differentiated by these.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import sympy

from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.kinematics import Kinematics, Twist
from kinolab.dynamics.derivation.vectors import Vector, Vectors
from kinolab.dynamics.language.forces import Load
from kinolab.dynamics.language.frames import Frame
from kinolab.dynamics.language.quantities import (
    Change,
    FrameQuantity,
    FrameSpeed,
    Place,
    frames_in,
    written,
)
from kinolab.dynamics.symbols.expressions import exact


class ProjectedForces:
    """Forces along each direction of motion, added to a total with an entry per direction."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._kinematics, self._vectors = kinematics, kinematics.vectors
        self._binding, self._tape = kinematics.binding, kinematics.tape
        self._rates = self._binding.at(kinematics.motions.velocities)

    def descend(self, total: list[Node], energy: sympy.Expr) -> None:
        """Add the force of a potential, -dV/dq."""
        self._push_along(total, self._tape.constant(-1.0), energy)

    def push(self, total: list[Node], load: Load, where: Callable[[], str]) -> None:
        """Add the force of a load; ``where`` says in an error what acts.

        Raises:
            InputError: If its velocity is not linear in the rates.
        """
        magnitude, velocity = self.value(exact(load.magnitude)), load.velocity
        if isinstance(velocity, Change):
            if velocity.position.is_number:  # both ends of a line are one point
                raise ZeroDivisionError("an expression divides by zero")
            self._push_along(total, magnitude, velocity.position)
        elif isinstance(velocity, FrameSpeed):
            wrench, scale = self.wrench(velocity), self._vectors.scale
            scaled = Twist(scale(magnitude, wrench.linear), scale(magnitude, wrench.angular))
            self.apply(total, velocity.on, scaled)
        else:
            node, _ = self._binding.linear_slopes(written(velocity), where)
            for i, direction in enumerate(self._kinematics.motions.directions):
                (share,) = self._tape.derivative([node], self._binding.at(direction))
                total[i] = self._tape.add(total[i], self._tape.mul(magnitude, share))

    def apply(self, total: list[Node], frame: Frame, wrench: Twist) -> None:
        """Add a force at the origin of a frame and a torque, in the frame's axes."""
        for i, column in enumerate(self._kinematics(frame).columns):
            total[i] = self._tape.add(total[i], power(self._vectors, wrench, column))

    def value(self, expression: sympy.Expr) -> Node:
        """Return what an expression is in the motion."""
        (node,) = self._known(expression, [self._binding.lower(expression)])
        return node

    def seen(self, frame: Frame, world: Vector) -> Vector:
        """Express a world vector in the axes of a frame."""
        rotation = self._kinematics(frame).rotation
        return self._vectors.transform(self._vectors.transpose(rotation), world)

    def wrench(self, speed: FrameSpeed) -> Twist:
        """Return the force and torque on a frame by which a speed of it is the power."""
        axis = self._kinematics.direction(speed.axis, speed.on)
        if speed.at is None:
            return Twist(self._vectors.zero, axis)
        arm = self._tape.substitute(self._kinematics.place(speed.at, speed.on), self._rates)
        return Twist(axis, self._vectors.cross(self._vectors.vector(arm), axis))

    def _push_along(self, total: list[Node], strength: Node, position: sympy.Expr) -> None:
        """Add a force along a function of coordinates and places."""
        tape, flow = self._tape, self._binding.flow
        for frame, gradient in self._by_places(position):
            force = self._vectors.scale(strength, gradient)
            self.apply(total, frame, Twist(force, self._vectors.zero))
        seeds = [flow(direction) for direction in self._kinematics.motions.directions]
        for i, slope in enumerate(self._slopes(position, seeds)):
            total[i] = tape.add(total[i], tape.mul(strength, slope))

    def _change(self, position: sympy.Expr) -> Node:
        """Return the time derivative of a function of coordinates and places."""
        flow = self._binding.flow(self._kinematics.motions.velocities)
        speeds = (
            self._tape.dot(slope, self._kinematics(frame).velocity.linear)
            for frame, slope in self._by_places(position)
        )
        return self._tape.sum([*speeds, *self._slopes(position, [flow])])

    def _by_places(self, position: sympy.Expr) -> Iterator[tuple[Frame, Vector]]:
        """Yield the derivative of a function by the place of each frame, in the frame's axes."""
        for frame in dict.fromkeys(frames_in(position)):
            places = [self._binding.lower(Place(frame, entry)) for entry in range(3)]
            slopes = self._slopes(position, [{node: self._tape.one} for node in places])
            yield frame, self.seen(frame, self._vectors.vector(slopes))

    def _slopes(self, position: sympy.Expr, along: Sequence[Mapping[Node, Node]]) -> list[Node]:
        """Return derivatives of a function along changes of coordinates, or of places, alone."""
        node = self._binding.lower(position)
        slopes = [self._tape.derivative([node], seeds)[0] for seeds in along]
        return self._known(position, slopes)

    def _known(self, expression: sympy.Expr, nodes: Sequence[Node]) -> list[Node]:
        """Put the motion's rates, and what quantities are in it, into nodes of an expression."""
        values = dict(self._rates)
        for quantity in sorted(expression.atoms(FrameQuantity), key=str):
            node = self._binding.lower(quantity)
            if isinstance(quantity, Change):
                values[node] = self._change(quantity.position)
            else:
                frame, entry = quantity.facts
                values[node] = self._kinematics(frame).position[entry]
        return self._tape.substitute(nodes, values)


def power(vectors: Vectors, wrench: Twist, twist: Twist) -> Node:
    """Return the power of a force and a torque on what moves with a twist."""
    linear = vectors.tape.dot(wrench.linear, twist.linear)
    return vectors.tape.add(linear, vectors.tape.dot(wrench.angular, twist.angular))
