"""Newton-Euler equations of a machine's bodies, projected onto directions of motion."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.kinematics import FrameState, Kinematics, Twist
from kinolab.dynamics.derivation.projected_forces import ProjectedForces, power
from kinolab.dynamics.derivation.vectors import Matrix3, Vector
from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.mechanism_parts import loads, potentials
from kinolab.dynamics.symbols.expressions import exact


class NewtonEuler:
    """Inertia and forces of a machine, projected onto the directions of its kinematics.

    Args:
        kinematics: Of its frames.
        massive: The bodies with mass or inertia; left out, all are gone through.
    """

    def __init__(self, kinematics: Kinematics, massive: Sequence[Body] | None = None) -> None:
        self.kinematics, self.binding = kinematics, kinematics.binding
        self.system = self.binding.system
        self._vectors, self._forces = kinematics.vectors, ProjectedForces(kinematics)
        self._bodies = self.system.bodies if massive is None else massive
        self._count = len(kinematics.motions.directions)

    def mass_matrix(self) -> list[list[Node]]:
        """Return the sum of J^T I J over the bodies; symmetric by construction."""
        tape, size = self.binding.tape, self._count
        M = [[tape.zero] * size for _ in range(size)]
        for body in self._bodies:
            columns = self.kinematics(body.frame).columns
            momenta = [self._momentum(body, column) for column in columns]
            for i in range(size):
                for j in range(i + 1):
                    M[i][j] = M[j][i] = tape.add(
                        M[i][j], power(self._vectors, momenta[i], columns[j])
                    )
        return M

    def inertial_forces(self) -> list[Node]:
        """Return the generalised inertial forces of given accelerations and velocities."""
        tape = self.binding.tape
        total = [tape.zero] * self._count
        for body in self._bodies:
            state = self.kinematics(body.frame)
            wrench = self._inertial_wrench(body, state)
            for i, column in enumerate(state.columns):
                total[i] = tape.add(total[i], power(self._vectors, wrench, column))
        return total

    def conservative_forces(self) -> list[Node]:
        """Return -dV/dq along each direction: weight, and the forces of potentials."""
        total = [self.binding.tape.zero] * self._count
        for body in self._bodies:
            field = self._forces.seen(body.frame, self._gravity())
            weight = self._vectors.scale(self.binding.lower(body.mass), field)
            self._forces.apply(total, body.frame, Twist(weight, self._vectors.zero))
        for energy in potentials(self.system):
            self._forces.descend(total, energy)
        return total

    def other_forces(self, *, dry: bool = True) -> list[Node]:
        """Return the forces of loads along each direction, those of inputs among them.

        Args:
            dry: Whether dry friction counts.
        """
        total = [self.binding.tape.zero] * self._count
        for word, load in loads(self.system, dry=dry):
            self._forces.push(total, load, partial(str, word))
        return total

    def energy(self) -> tuple[Node, Node]:
        """Return kinetic and potential energy."""
        tape, lower = self.binding.tape, self.binding.lower
        kinetic, potential = tape.zero, tape.zero
        for body in self._bodies:
            state = self.kinematics(body.frame)
            momentum = self._momentum(body, state.velocity)
            kinetic = tape.add(kinetic, power(self._vectors, momentum, state.velocity))
            fall = tape.dot(self._gravity(), state.position)
            potential = tape.sub(potential, tape.mul(lower(body.mass), fall))
        for energy in potentials(self.system):
            potential = tape.add(potential, self._forces.value(energy))
        return tape.mul(tape.constant(0.5), kinetic), potential

    def _gravity(self) -> Vector:
        """Return gravity in world axes, in [m/s^2]."""
        field = self.system.gravity
        if field is None:
            return self._vectors.zero
        lower = self.binding.lower
        down = self._vectors.vector([lower(exact(component)) for component in field.down])
        return self._vectors.scale(lower(exact(field.strength)), down)

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
        entries, lower = body.inertia_matrix, self.binding.lower
        a, b, c = (self._vectors.vector([lower(entries[i, j]) for j in range(3)]) for i in range(3))
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
