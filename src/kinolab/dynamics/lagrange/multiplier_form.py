"""Equations of motion from energies and Lagrange multipliers, evaluated as numbers.

The second of two derivations. The one that is compiled projects each body's Newton-Euler equations
onto the motions that constraints allow, in an expression graph of its own. This one differentiates
kinetic and potential energy, keeps every velocity v and every constraint, and solves

    M a + c = Q + A^T lambda,    A a + A_dot v = b

at each instant for the accelerations a and the multipliers lambda. Both start from the same
description of the machine, and share nothing that follows from it but the choice of the velocities
that are states.

Source: Bloch, Nonholonomic Mechanics and Control, 2003, chapters 3 and 5; Murray, Li, Sastry, A
Mathematical Introduction to Robotic Manipulation, 1994, section 6.1.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics.lagrange.hyper_dual import Evaluation, HyperDual, Instruction
from kinolab.numerics.arrays import Array


@dataclass(frozen=True)
class VelocityRow:
    """A velocity that a constraint, an input or an auxiliary state imposes, as instructions.

    Attributes:
        velocity: Linear in the rates.
        equals: What it is.
        change: The derivative of that.
    """

    velocity: int
    equals: int
    change: int


@dataclass(frozen=True)
class MultiplierForm:
    """A machine's equations of motion in all velocities and multipliers, as plain data.

    Every number below is the place of a formula among ``instructions``.

    Attributes:
        instructions: All formulas.
        coordinates: Names of the entries of each coordinate: four of an attitude, else one.
        velocities: Names of all velocities: three of an attitude, else one per coordinate.
        inputs: Names of the inputs.
        further_names: Names of the auxiliary states.
        parameters: Names and values.
        kinetic: Kinetic energy in [J]; None of a machine without mass.
        potential: Potential energy in [J].
        position_loads: Strength of a force, and the function of the coordinates along which it
            acts.
        velocity_loads: Strength of a force, and the velocity along which it acts.
        imposed: Velocities that are not free.
        driven: Index of each velocity whose derivative is an input, and the input.
        states: The velocities that are states, linear in the rates.
        further: Derivatives of the auxiliary states.
    """

    instructions: tuple[Instruction, ...]
    coordinates: tuple[tuple[str, ...], ...]
    velocities: tuple[str, ...]
    inputs: tuple[str, ...]
    further_names: tuple[str, ...]
    parameters: tuple[tuple[str, float], ...]
    kinetic: int | None
    potential: int
    position_loads: tuple[tuple[int, ...], ...]
    velocity_loads: tuple[tuple[int, ...], ...]
    imposed: tuple[VelocityRow, ...]
    driven: tuple[tuple[int, int], ...]
    states: tuple[int, ...]
    further: tuple[int, ...]

    def derivative(self, x: Array, u: Array) -> Array:
        """Return the derivatives of states (m, nx) under inputs (m, nu), shape (m, nx).

        They are NaN at an instant at which something is undefined.
        """
        x, u = np.asarray(x, dtype=float), np.asarray(u, dtype=float)
        nq = sum(map(len, self.coordinates))
        known = self._values(x, u, nq)
        with np.errstate(all="ignore"):
            speeds = self._speeds(known, x[:, nq : nq + len(self.states)])
            instants = _Instants(self, known, speeds)
            massless = self.kinetic is None and not self.driven
            accelerations = None if massless else instants.accelerations()
            changes = [*instants.flow, *instants.state_changes(accelerations)]
            changes += [instants(place).value for place in self.further]
        return np.stack(changes, axis=1)

    def _values(self, x: Array, u: Array, nq: int) -> dict[str, Array]:
        """Return the values of all variables but velocities, each of shape (m,)."""
        names = [name for entries in self.coordinates for name in entries]
        first = x.shape[1] - len(self.further_names)
        columns = [*x[:, :nq].T, *x[:, first:].T, *u.T]
        fixed = {name: np.full(len(x), value) for name, value in self.parameters}
        names += [*self.further_names, *self.inputs]
        return fixed | dict(zip(names, columns, strict=True))

    def _speeds(self, known: Mapping[str, Array], v: Array) -> Array:
        """Return all velocities, shape (m, n), from those that are states (m, nv).

        Where all of them are states, they are taken as they are, on the constraints or beside them.
        """
        rest = _Instants(self, known, np.zeros((len(v), len(self.velocities))))
        imposed = self.imposed if len(self.states) < len(self.velocities) else ()
        rows = [rest(entry.velocity) for entry in imposed]
        wanted = [rest(entry.equals).value for entry in imposed]
        rows += [rest(place) for place in self.states]
        A = np.stack([rest.along_velocities(row) for row in rows], axis=1)
        pairs = zip(rows, [*wanted, *v.T], strict=True)
        return _solved(A, np.stack([value - row.value for row, value in pairs], axis=1))


class _Instants:
    """The machine at m instants, at given positions and velocities.

    Derivatives are taken along the n velocities, along the motion itself, and along n turns and
    shifts of the configuration, in this order.
    """

    def __init__(self, form: MultiplierForm, values: Mapping[str, Array], speeds: Array) -> None:
        self.form, self.speeds = form, speeds
        m, n = speeds.shape
        known = {name: HyperDual(value) for name, value in values.items()}
        for k, name in enumerate(form.velocities):
            slope = np.zeros((m, 2 * n + 1))
            slope[:, k] = 1.0
            known[name] = HyperDual(speeds[:, k], slope)
        self.flow: list[Array] = []  # q_dot, each of shape (m,)
        for names, axes in self._axes():
            directions = _directions([values[name] for name in names])
            for k, name in enumerate(names):
                slope = np.zeros((m, 2 * n + 1))
                slope[:, n + 1 + axes.start : n + 1 + axes.stop] = directions[:, k]
                slope[:, n] = (directions[:, k] * speeds[:, axes]).sum(axis=1)
                known[name] = HyperDual(values[name], slope)
                self.flow.append(slope[:, n])
        self._evaluation = Evaluation(form.instructions, known, n)

    def __call__(self, place: int) -> HyperDual:
        """Evaluate a formula with its derivatives."""
        return self._evaluation(place)

    def _axes(self) -> Iterator[tuple[tuple[str, ...], slice]]:
        """Yield the entries of each coordinate, and which velocities are its own."""
        first = 0
        for names in self.form.coordinates:
            size = 1 if len(names) == 1 else 3
            yield names, slice(first, first + size)
            first += size

    def along_velocities(self, quantity: HyperDual) -> Array:
        """Return d/dv, shape (m, n)."""
        m, n = self.speeds.shape
        return np.zeros((m, n)) if quantity.slope is None else quantity.slope[:, :n]

    def along_configuration(self, quantity: HyperDual) -> Array:
        """Return the derivatives along turns and shifts of the configuration, shape (m, n)."""
        m, n = self.speeds.shape
        return np.zeros((m, n)) if quantity.slope is None else quantity.slope[:, n + 1 :]

    def accelerations(self) -> Array:
        """Solve the equations of motion for a, shape (m, n)."""
        form, (m, n) = self.form, self.speeds.shape
        A, b = self._held()
        if form.kinetic is None:  # without masses inputs alone accelerate it
            return _solved(A, b)
        T, V = self(form.kinetic), self(form.potential)
        assert T.slope is not None
        assert T.bend is not None
        M, momentum = T.bend[:, :, :n], T.slope[:, :n]
        force = self.along_configuration(T) - T.bend[:, :, n] - self.along_configuration(V)
        for names, axes in self._axes():
            if len(names) > 1:  # Euler-Poincare: seen from axes that turn
                force[:, axes] -= np.cross(self.speeds[:, axes], momentum[:, axes])
        for strength, position in form.position_loads:
            force += self(strength).value[:, None] * self.along_configuration(self(position))
        for strength, velocity in form.velocity_loads:
            force += self(strength).value[:, None] * self.along_velocities(self(velocity))
        whole = np.zeros((m, n + A.shape[1], n + A.shape[1]))
        whole[:, :n, :n], whole[:, n:, :n] = M, A
        whole[:, :n, n:] = -A.transpose(0, 2, 1)
        return _solved(whole, np.concatenate([force, b], axis=1))[:, :n]

    def _held(self) -> tuple[Array, Array]:
        """Return A (m, k, n) and b - A_dot v (m, k) of all that forces of constraint hold."""
        m, n = self.speeds.shape
        A, b = [np.zeros((m, 0, n))], [np.zeros((m, 0))]
        for entry in self.form.imposed:
            row = self(entry.velocity)
            A.append(self.along_velocities(row)[:, None])
            b.append((self(entry.change).value - self._drift(row))[:, None])
        for index, place in self.form.driven:
            A.append(np.broadcast_to(np.eye(n)[index], (m, 1, n)))
            b.append(self(place).value[:, None])
        return np.concatenate(A, axis=1), np.concatenate(b, axis=1)

    def _drift(self, row: HyperDual) -> Array:
        """Return A_dot v of a velocity that is A v, shape (m,)."""
        if row.bend is None:
            return np.zeros(len(self.speeds))
        return np.asarray((row.bend[:, :, -1] * self.speeds).sum(axis=1))

    def state_changes(self, accelerations: Array | None) -> Iterator[Array]:
        """Yield the derivative of each velocity that is a state, shape (m,)."""
        for place in self.form.states:
            assert accelerations is not None, "a machine without mass has no such states"
            row = self(place)
            yield (self.along_velocities(row) * accelerations).sum(axis=1) + self._drift(row)


def _directions(entries: Sequence[Array]) -> Array:
    """Return how the entries of a coordinate change with each of its velocities, (m, entries, k).

    A quaternion q changes by q_dot = 1/2 q * (omega, 0), omega in body axes.
    """
    if len(entries) == 1:
        return np.ones((len(entries[0]), 1, 1))
    x, y, z, w = entries
    rows = [[w, -z, y], [z, w, -x], [-y, x, w], [-x, -y, -z]]
    return np.moveaxis(np.array(rows), 2, 0) / 2


def _solved(A: Array, b: Array) -> Array:
    """Return the least-norm solutions of m systems A x = b, shape (m, n), once equilibrated.

    Masses of a milligram and constraints in radians stand in one matrix; what is small for its unit
    alone must not count as nothing.
    """
    sound = np.isfinite(A).all(axis=(1, 2)) & np.isfinite(b).all(axis=1)
    x = np.full((len(b), A.shape[2]), np.nan)
    A, b = A[sound], b[sound]
    rows, columns = _equilibration(A)
    scaled, found = rows[:, :, None] * A * columns[:, None, :], np.zeros((len(b), A.shape[2]))
    for k in range(len(b)):
        for _ in range(3):  # of solutions, by what they leave of the right-hand side
            missing = rows[k] * (b[k] - A[k] @ found[k])
            found[k] += columns[k] * np.linalg.lstsq(scaled[k], missing, rcond=None)[0]
    x[sound] = found
    return x


def _equilibration(A: Array) -> tuple[Array, Array]:
    """Return factors of rows and columns of matrices (k, m, n) that make their largest entries 1.

    Source: Ruiz, A scaling algorithm to equilibrate both rows and columns norms in matrices,
    RAL-TR-2001-034, 2001.
    """
    rows, columns = np.ones(A.shape[:2]), np.ones((len(A), A.shape[2]))
    for _ in range(12):  # each halves the decades that a largest entry is away from 1
        sizes = np.abs(rows[:, :, None] * A * columns[:, None, :])
        tallest, widest = sizes.max(axis=2, initial=0.0), sizes.max(axis=1, initial=0.0)
        rows /= np.sqrt(np.where(tallest > 0, tallest, 1.0))
        columns /= np.sqrt(np.where(widest > 0, widest, 1.0))
    return rows, columns
