"""Potentials and loads, projected onto the directions of motion of a machine.

A force along a quantity of frames, such as the distance of two, is applied to these frames: its
slope by the quantity is the magnitude of a wrench, whose power with each direction is the force
along it. What is stated in coordinates and rates is differentiated by these.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import sympy

from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.kinematics import Kinematics, Twist
from kinolab.dynamics.derivation.vectors import Vector, Vectors
from kinolab.dynamics.language.expressions import exact
from kinolab.dynamics.language.forces import Load
from kinolab.dynamics.language.frames import Frame
from kinolab.dynamics.language.quantities import (
    Change,
    FrameQuantity,
    FrameSpeed,
    Height,
    PointSpeed,
    SquaredDistance,
    Up,
    written,
)


class ProjectedForces:
    """Forces along each direction of motion, added to a total with an entry per direction.

    Args:
        kinematics: Of the machine's frames.
        up: Unit vector against gravity.
    """

    def __init__(self, kinematics: Kinematics, up: Up) -> None:
        self._kinematics, self._vectors = kinematics, kinematics.vectors
        self._binding, self._tape = kinematics.binding, kinematics.tape
        self._up = up
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
            self._push_along(total, magnitude, velocity.position)
        elif isinstance(velocity, FrameSpeed):
            self.apply(total, velocity.on, self._scaled(magnitude, self.wrench(velocity)))
        else:
            node, _ = self._binding.linear_slopes(written(velocity, self._up), where)
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
        if isinstance(speed, PointSpeed):
            axis = self._kinematics.direction(speed.along, speed.on)
            arm = self._kinematics.place(speed.at, speed.on)
            arm = self._vectors.vector(self._tape.substitute(arm, self._rates))
            return Twist(axis, self._vectors.cross(arm, axis))
        return Twist(self._vectors.zero, self._kinematics.direction(speed.about, speed.on))

    def _push_along(self, total: list[Node], strength: Node, position: sympy.Expr) -> None:
        """Add a force along a function of coordinates and quantities of frames."""
        tape, flow = self._tape, self._binding.flow
        for frame, wrench in self._wrenches(position):
            self.apply(total, frame, self._scaled(strength, wrench))
        seeds = [flow(direction) for direction in self._kinematics.motions.directions]
        for i, slope in enumerate(self._slopes(position, seeds)):
            total[i] = tape.add(total[i], tape.mul(strength, slope))

    def _change(self, position: sympy.Expr) -> Node:
        """Return the time derivative of a function of coordinates and quantities of frames."""
        flow = self._binding.flow(self._kinematics.motions.velocities)
        speeds = (
            power(self._vectors, wrench, self._kinematics(frame).velocity)
            for frame, wrench in self._wrenches(position)
        )
        return self._tape.sum([*speeds, *self._slopes(position, [flow])])

    def _slopes(self, position: sympy.Expr, along: Sequence[Mapping[Node, Node]]) -> list[Node]:
        """Return derivatives of a function along changes of coordinates or quantities alone."""
        node = self._binding.lower(position)
        slopes = [self._tape.derivative([node], seeds)[0] for seeds in along]
        return self._known(position, slopes)

    def _wrenches(self, position: sympy.Expr) -> Iterator[tuple[Frame, Twist]]:
        """Yield the forces on frames whose work is the change of a function of quantities."""
        quantities, one = _quantities_in(position), self._tape.one
        seeds = [{self._binding.lower(quantity): one} for quantity in quantities]
        slopes = self._slopes(position, seeds)
        for quantity, slope in zip(quantities, slopes, strict=True):
            for frame, world in self._gradient(quantity):
                force = self._vectors.scale(slope, self.seen(frame, world))
                yield frame, Twist(force, self._vectors.zero)

    def _gradient(self, quantity: FrameQuantity) -> Iterator[tuple[Frame, Vector]]:
        """Yield the derivative of a quantity by the place of each frame, in world axes."""
        if isinstance(quantity, Height):
            yield quantity.frame, self._skyward
        elif isinstance(quantity, SquaredDistance):
            first, second = quantity.between
            path = self._path(quantity)
            for sign, frame in ((-2.0, first), (2.0, second)):
                yield frame, self._vectors.scale(self._tape.constant(sign), path)

    @property
    def _skyward(self) -> Vector:
        return self._vectors.vector([self._tape.constant(component) for component in self._up])

    def _path(self, quantity: SquaredDistance) -> Vector:
        first, second = (self._kinematics(frame).position for frame in quantity.between)
        return self._vectors.sub(second, first)

    def _quantity(self, quantity: FrameQuantity) -> Node:
        """Return what a quantity is in the motion."""
        if isinstance(quantity, Change):
            return self._change(quantity.position)
        if isinstance(quantity, Height):
            return self._vectors.dot(self._skyward, self._kinematics(quantity.frame).position)
        assert isinstance(quantity, SquaredDistance)
        path = self._path(quantity)
        return self._vectors.dot(path, path)

    def _known(self, expression: sympy.Expr, nodes: Sequence[Node]) -> list[Node]:
        """Put the motion's rates, and what quantities are in it, into nodes of an expression."""
        quantities = _quantities_in(expression)
        values = {self._binding.lower(one): self._quantity(one) for one in quantities}
        return self._tape.substitute(nodes, {**self._rates, **values})

    def _scaled(self, strength: Node, wrench: Twist) -> Twist:
        scale = self._vectors.scale
        return Twist(scale(strength, wrench.linear), scale(strength, wrench.angular))


def power(vectors: Vectors, wrench: Twist, twist: Twist) -> Node:
    """Return the power of a force and a torque on what moves with a twist."""
    linear = vectors.dot(wrench.linear, twist.linear)
    return vectors.tape.add(linear, vectors.dot(wrench.angular, twist.angular))


def _quantities_in(expression: sympy.Expr) -> list[FrameQuantity]:
    return sorted(expression.atoms(FrameQuantity), key=str)
