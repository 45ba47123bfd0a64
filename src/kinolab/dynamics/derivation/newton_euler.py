"""Newton-Euler equations of a machine's bodies, projected onto directions of motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import sympy

from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.kinematics import FrameState, Kinematics, Twist
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.derivation.vectors import Matrix3, Vector, Vectors
from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.expressions import is_zero
from kinolab.dynamics.language.forces import (
    Buoyancy,
    Coulomb,
    Friction,
    Potential,
    Rope,
    SlidingFriction,
    Spring,
    Viscous,
    Wrench,
    effort_name,
)
from kinolab.dynamics.language.frames import Frame
from kinolab.dynamics.language.inputs import Control, Drive, Force, Input, Pull, Rate, Torque
from kinolab.dynamics.language.mechanism import Mechanism


@dataclass(frozen=True)
class NewtonEuler:
    """Inertia and forces of a machine, projected onto the directions of its kinematics.

    Attributes:
        system: The machine.
        binding: Its symbols.
        kinematics: Of its frames.
        massive: The bodies with mass or inertia; left out, all are gone through.
    """

    system: Mechanism
    binding: SymbolTable
    kinematics: Kinematics
    massive: Sequence[Body] | None = None

    @property
    def _vectors(self) -> Vectors:
        return self.kinematics.vectors

    @property
    def _bodies(self) -> Sequence[Body]:
        return self.system.bodies if self.massive is None else self.massive

    @property
    def _count(self) -> int:
        return len(self.kinematics.motions.directions)

    def mass_matrix(self) -> list[list[Node]]:
        """Return the sum of J^T I J over the bodies; symmetric by construction."""
        tape, size = self.binding.tape, self._count
        M = [[tape.zero] * size for _ in range(size)]
        for body in self._bodies:
            columns = self.kinematics(body.frame).columns
            momenta = [self._momentum(body, column) for column in columns]
            for i in range(size):
                for j in range(i + 1):
                    M[i][j] = M[j][i] = tape.add(M[i][j], self._power(momenta[i], columns[j]))
        return M

    def inertial_forces(self) -> list[Node]:
        """Return the generalised inertial forces of given accelerations and velocities."""
        tape = self.binding.tape
        total = [tape.zero] * self._count
        for body in self._bodies:
            state = self.kinematics(body.frame)
            wrench = self._inertial_wrench(body, state)
            for i, column in enumerate(state.columns):
                total[i] = tape.add(total[i], self._power(wrench, column))
        return total

    def conservative_forces(self) -> list[Node]:
        """Return -dV/dq along each direction: gravity, springs, ropes, buoyancy, potentials."""
        total = [self.binding.tape.zero] * self._count
        for body in self._bodies:
            self._apply(total, body.frame, self._weight(body))
        for effort in self.system.efforts:
            match effort:
                case Potential():
                    self._descend(total, effort.energy)
                case Spring():
                    self._pull(total, effort.between, self._tension(effort))
                case Rope():
                    self._tighten(total, effort, self._elastic(effort))
                case Buoyancy():
                    lift = self._lift(effort)
                    self._apply(total, effort.on.frame, lift, at=self._lower(effort.at))
        return total

    def other_forces(self, *, dry: bool = True) -> list[Node]:
        """Return friction, damping of ropes, wrenches and inputs along each direction.

        Args:
            dry: Whether Coulomb's friction counts.
        """
        total = [self.binding.tape.zero] * self._count
        for effort in self.system.efforts:
            match effort:
                case Viscous():
                    strength = self.binding.lower(effort.coefficient * effort.velocity)
                    self._resist(total, effort, effort.velocity, strength)
                case Coulomb() if dry:
                    slip = sympy.tanh(effort.velocity / effort.smoothing)
                    strength = self.binding.lower(effort.strength * slip)
                    self._resist(total, effort, effort.velocity, strength)
                case Rope() if not is_zero(effort.damping):
                    self._tighten(total, effort, self._damped(effort))
                case SlidingFriction():
                    size = sympy.sqrt(sum(v**2 for v in (*effort.slip, effort.smoothing)))
                    for velocity in effort.slip:
                        strength = self.binding.lower(effort.strength * velocity / size)
                        self._resist(total, effort, velocity, strength)
                case Wrench():
                    self._wrench(total, effort)
        for entry in self.system.inputs:
            self._input(total, entry)
        return total

    def energy(self) -> tuple[Node, Node]:
        """Return kinetic and potential energy."""
        tape, lower, vectors = self.binding.tape, self.binding.lower, self._vectors
        kinetic, potential = tape.zero, tape.zero
        for body in self._bodies:
            state = self.kinematics(body.frame)
            momentum = self._momentum(body, state.velocity)
            kinetic = tape.add(kinetic, self._power(momentum, state.velocity))
            fall = vectors.dot(self._gravity(), state.position)
            potential = tape.sub(potential, tape.mul(lower(body.mass), fall))
        for effort in self.system.efforts:
            match effort:
                case Potential():
                    potential = tape.add(potential, lower(effort.energy))
                case Spring():
                    potential = tape.add(potential, self._stored(effort))
                case Rope():
                    half = tape.mul(tape.constant(0.5), self._elastic(effort))
                    stored = tape.mul(half, tape.maximum(self._stretch(effort), tape.zero))
                    potential = tape.add(potential, stored)
                case Buoyancy():
                    state = self.kinematics(effort.on.frame)
                    arm = vectors.transform(state.rotation, self._lower(effort.at))
                    rise = vectors.dot(self._up(), vectors.add(state.position, arm))
                    potential = tape.sub(potential, tape.mul(lower(effort.lift), rise))
        return tape.mul(tape.constant(0.5), kinetic), potential

    def _lower(self, components: Sequence[sympy.Expr]) -> Vector:
        return self._vectors.vector([self.binding.lower(component) for component in components])

    def _gravity(self) -> Vector:
        """Return gravity in world axes, in [m/s^2]."""
        field, tape = self.system.gravity, self.binding.tape
        if field is None:
            return self._vectors.zero
        down = self._vectors.vector([tape.constant(component) for component in field.down])
        return self._vectors.scale(self.binding.lower(field.strength), down)

    def _up(self) -> Vector:
        tape, field = self.binding.tape, self.system.gravity
        down = field.down if field is not None else (0.0, 0.0, -1.0)
        return self._vectors.vector([tape.constant(-component) for component in down])

    def _seen(self, body_state: FrameState, world: Vector) -> Vector:
        """Express a world vector in a body's axes."""
        return self._vectors.transform(self._vectors.transpose(body_state.rotation), world)

    def _weight(self, body: Body) -> Vector:
        field = self._seen(self.kinematics(body.frame), self._gravity())
        return self._vectors.scale(self.binding.lower(body.mass), field)

    def _lift(self, effort: Buoyancy) -> Vector:
        up = self._seen(self.kinematics(effort.on.frame), self._up())
        return self._vectors.scale(self.binding.lower(effort.lift), up)

    def _momentum(self, body: Body, twist: Twist) -> Twist:
        """Return linear and angular momentum, added mass included."""
        vectors, lower = self._vectors, self.binding.lower
        rigid = Twist(
            vectors.scale(lower(body.mass), twist.linear),
            vectors.transform(self._inertia(body), twist.angular),
        )
        if not body.added_mass:
            return rigid
        fluid = self._fluid_momentum(body, twist)
        return Twist(
            vectors.add(rigid.linear, fluid.linear), vectors.add(rigid.angular, fluid.angular)
        )

    def _inertia(self, body: Body) -> Matrix3:
        entries = body.inertia_matrix
        a, b, c = (self._lower([entries[i, j] for j in range(3)]) for i in range(3))
        return a, b, c

    def _fluid_momentum(self, body: Body, twist: Twist) -> Twist:
        tape, lower = self.binding.tape, self.binding.lower
        velocity = (*twist.linear, *twist.angular)
        rows = [tape.dot(map(lower, row), velocity) for row in body.added_mass]
        return Twist(self._vectors.vector(rows[:3]), self._vectors.vector(rows[3:]))

    def _inertial_wrench(self, body: Body, state: FrameState) -> Twist:
        """Return m a and I alpha + omega x I omega, and Kirchhoff's terms of the fluid."""
        vectors, lower = self._vectors, self.binding.lower
        inertia, spin = self._inertia(body), state.velocity.angular
        gyroscopic = vectors.cross(spin, vectors.transform(inertia, spin))
        angular = vectors.add(vectors.transform(inertia, state.acceleration.angular), gyroscopic)
        rigid = Twist(vectors.scale(lower(body.mass), state.acceleration.linear), angular)
        if not body.added_mass:
            return rigid
        fluid = self._kirchhoff(body, state)
        return Twist(
            vectors.add(rigid.linear, fluid.linear), vectors.add(rigid.angular, fluid.angular)
        )

    def _kirchhoff(self, body: Body, state: FrameState) -> Twist:
        """Return dP/dt + omega x P and dPi/dt + omega x Pi + v x P of the fluid's momentum.

        Source: Lamb, Hydrodynamics, 6th ed., section 124.
        """
        vectors = self._vectors
        linear, spin = state.velocity.linear, state.velocity.angular
        change = vectors.sub(state.acceleration.linear, vectors.cross(spin, linear))
        rate = self._fluid_momentum(body, Twist(change, state.acceleration.angular))
        momentum = self._fluid_momentum(body, state.velocity)
        return Twist(
            vectors.add(rate.linear, vectors.cross(spin, momentum.linear)),
            vectors.add(
                rate.angular,
                vectors.cross(spin, momentum.angular),
                vectors.cross(linear, momentum.linear),
            ),
        )

    def _power(self, wrench: Twist, twist: Twist) -> Node:
        vectors = self._vectors
        linear = vectors.dot(wrench.linear, twist.linear)
        return self.binding.tape.add(linear, vectors.dot(wrench.angular, twist.angular))

    def _apply(
        self,
        total: list[Node],
        frame: Frame,
        force: Vector,
        torque: Vector | None = None,
        at: Vector | None = None,
    ) -> None:
        """Add a force at a point of a frame and a torque, in the frame's axes."""
        vectors = self._vectors
        moment = torque or vectors.zero
        if at is not None:
            moment = vectors.add(moment, vectors.cross(at, force))
        wrench = Twist(force, moment)
        for i, column in enumerate(self.kinematics(frame).columns):
            total[i] = self.binding.tape.add(total[i], self._power(wrench, column))

    def _react(self, total: list[Node], on: Body, other: Body, wrench: Twist, at: Vector) -> None:
        """Add the reaction of a wrench on one body, with the same line of action, to another."""
        vectors = self._vectors
        here, there = self.kinematics(on.frame), self.kinematics(other.frame)

        def carried(vector: Vector) -> Vector:
            return self._seen(there, vectors.transform(here.rotation, vector))

        place = vectors.add(here.position, vectors.transform(here.rotation, at))
        arm = self._seen(there, vectors.sub(place, there.position))
        minus = self.binding.tape.constant(-1.0)
        force, torque = (vectors.scale(minus, carried(v)) for v in (wrench.linear, wrench.angular))
        self._apply(total, other.frame, force, torque, arm)

    def _descend(self, total: list[Node], energy: sympy.Expr) -> None:
        tape = self.binding.tape
        node = self.binding.lower(energy)
        for i, direction in enumerate(self.kinematics.motions.directions):
            (slope,) = tape.derivative([node], self.binding.flow(direction))
            total[i] = tape.sub(total[i], slope)

    def _resist(
        self, total: list[Node], effort: Friction, velocity: sympy.Expr, strength: Node
    ) -> None:
        """Subtract a force along a velocity; the strength may depend on velocity variables."""
        tape, motions = self.binding.tape, self.kinematics.motions
        node, _ = self.binding.linear_slopes(velocity, partial(effort_name, effort))
        (actual,) = tape.substitute([strength], self.binding.at(motions.velocities))
        for i, direction in enumerate(motions.directions):
            (fraction,) = tape.derivative([node], self.binding.at(direction))
            total[i] = tape.sub(total[i], tape.mul(actual, fraction))

    def _line(self, between: tuple[Frame, Frame]) -> tuple[Vector, Node]:
        """Return the vector from the first frame's origin to the second's, and its length."""
        first, second = (self.kinematics(frame) for frame in between)
        path = self._vectors.sub(second.position, first.position)
        return path, self._vectors.norm(path)

    def _tension(self, spring: Spring) -> Node:
        """Return the tension per length, which is finite at length 0 if the rest length is 0."""
        tape, lower = self.binding.tape, self.binding.lower
        stiffness, rest = lower(spring.stiffness), lower(spring.length)
        if rest == tape.zero:
            return stiffness
        _, length = self._line(spring.between)
        return tape.mul(stiffness, tape.sub(tape.one, tape.div(rest, length)))

    def _stored(self, spring: Spring) -> Node:
        tape, lower = self.binding.tape, self.binding.lower
        path, _ = self._line(spring.between)
        rest = lower(spring.length)
        square = self._vectors.dot(path, path)
        if rest != tape.zero:
            stretch = tape.sub(self._line(spring.between)[1], rest)
            square = tape.mul(stretch, stretch)
        half = tape.mul(tape.constant(0.5), lower(spring.stiffness))
        return tape.mul(half, square)

    def _pull(self, total: list[Node], between: tuple[Frame, Frame], per_length: Node) -> None:
        """Add a tension between two origins, given per length of the line."""
        path, _ = self._line(between)
        force = self._vectors.scale(per_length, path)
        minus = self._vectors.scale(self.binding.tape.constant(-1.0), force)
        for frame, world in zip(between, (force, minus), strict=True):
            self._apply(total, frame, self._seen(self.kinematics(frame), world))

    def _span(self, rope: Rope) -> Node:
        """Return the length of a rope that is taut; of a slack one no less, to divide by."""
        _, length = self._line(rope.between)
        return self.binding.tape.maximum(length, self.binding.lower(rope.length))

    def _stretch(self, rope: Rope) -> Node:
        """Return the stretch of a rope, negative where it is slack."""
        _, length = self._line(rope.between)
        return self.binding.tape.sub(length, self.binding.lower(rope.length))

    def _elastic(self, rope: Rope) -> Node:
        """Return the tension of a rope at rest."""
        tape = self.binding.tape
        stretch = tape.maximum(self._stretch(rope), tape.zero)
        return tape.mul(self.binding.lower(rope.stiffness), stretch)

    def _damped(self, rope: Rope) -> Node:
        """Return what damping adds to a rope's tension; it takes away all of it at most."""
        tape, lower = self.binding.tape, self.binding.lower
        half = tape.constant(0.5)
        taut = tape.add(half, tape.mul(half, tape.unary("sign", self._stretch(rope))))
        force = tape.mul(lower(rope.damping), tape.mul(taut, self._stretch_rate(rope)))
        return tape.maximum(force, tape.neg(self._elastic(rope)))

    def _stretch_rate(self, rope: Rope) -> Node:
        tape, vectors = self.binding.tape, self._vectors
        path, _ = self._line(rope.between)
        first, second = (
            vectors.transform(state.rotation, state.velocity.linear)
            for state in map(self.kinematics, rope.between)
        )
        parting = tape.div(vectors.dot(path, vectors.sub(second, first)), self._span(rope))
        flow = self.binding.flow(self.kinematics.motions.velocities)
        (unwinding,) = tape.derivative([self.binding.lower(rope.length)], flow)
        return tape.sub(parting, unwinding)

    def _tighten(self, total: list[Node], rope: Rope, tension: Node) -> None:
        """Add a rope's tension: it pulls its ends together and unwinds it from its winch."""
        tape, rest = self.binding.tape, self.binding.lower(rope.length)
        self._pull(total, rope.between, tape.div(tension, self._span(rope)))
        for i, direction in enumerate(self.kinematics.motions.directions):
            (longer,) = tape.derivative([rest], self.binding.flow(direction))
            total[i] = tape.add(total[i], tape.mul(tension, longer))

    def _wrench(self, total: list[Node], effort: Wrench) -> None:
        actual = self.binding.at(self.kinematics.motions.velocities)
        force, torque, at = (
            self._vectors.vector(self.binding.tape.substitute(self._lower(part), actual))
            for part in (effort.force, effort.torque, effort.at)
        )
        self._apply(total, effort.on.frame, force, torque, at)
        if effort.reacts_on is not None:
            self._react(total, effort.on, effort.reacts_on, Twist(force, torque), at)

    def _input(self, total: list[Node], entry: Input) -> None:
        vectors, tape = self._vectors, self.binding.tape
        value = self.binding.lower(entry.symbol)
        match entry:
            case Torque():
                for body, sign in ((entry.on, 1.0), (entry.reacts_on, -1.0)):
                    if body is not None:
                        axis = self.kinematics.direction(entry.about, body.frame)
                        signed = tape.mul(tape.constant(sign), value)
                        self._apply(total, body.frame, vectors.zero, vectors.scale(signed, axis))
            case Force():
                axis = self.kinematics.direction(entry.along, entry.on.frame)
                push = vectors.scale(value, axis)
                self._apply(total, entry.on.frame, push)
                if entry.reacts_on is not None:
                    wrench = Twist(push, vectors.zero)
                    self._react(total, entry.on, entry.reacts_on, wrench, vectors.zero)
            case Pull():
                _, length = self._line(entry.between)
                self._pull(total, entry.between, tape.div(value, length))
            case Rate() | Drive() | Control():
                pass  # they act through velocity coordinates and expressions
