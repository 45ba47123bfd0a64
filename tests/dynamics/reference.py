"""A machine's equations of motion a second time: point masses, numbers and Cauchy's integral.

Nothing here uses kinolab's kinematics, derivatives or linear algebra, only a machine's description:
the motions a frame was made of, masses, inertias, constraint expressions, inputs.

* A rigid body of mass m is six equal point masses on its principal axes, at the distances a_i that
  give it the inertia: I_x = m/3 (a_y^2 + a_z^2). No angular velocity is ever needed for it.
* Derivatives along a line q + s d are Cauchy's integral over a circle in s, exact to rounding for
  the entire functions (sines, polynomials, exponentials) that these machines are made of.

Sources:
    Goldstein, Classical Mechanics, 3rd ed., section 1.4: d'Alembert's principle for point masses.
    Lyness, Moler, SIAM J. Numer. Anal. 4(2), 1967: derivatives by Cauchy's integral.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from kinolab.dynamics import Axis, Body, Coordinate, Force, Frame, System, Torque, rate
from kinolab.dynamics.language.constraints import VelocityConstraint
from kinolab.dynamics.language.frames import Rotation, Translation

Array = NDArray[Any]
NODES = 32  # points on the circle; aliasing is radius^32 times the 33rd Taylor coefficient
RADIUS = 0.25  # of the circle


def taylor(function: Callable[[Array], Array], q: Array, direction: Array) -> list[Array]:
    """Value, first and second derivative in s of function(q + s direction) at s = 0.

    ``function`` maps (NODES, nq) to (NODES, ...), complex, and is real on real arguments.
    """
    s = RADIUS * np.exp(2j * np.pi * np.arange(NODES) / NODES)
    values = function(np.asarray(q) + s[:, None] * np.asarray(direction))
    shape = (NODES,) + (1,) * (values.ndim - 1)
    return [
        np.real(factor * np.mean(values * s.reshape(shape) ** -order, axis=0))
        for order, factor in ((0, 1), (1, 1), (2, 2))
    ]


def compiled(expression: Any, symbols: Sequence[Any]) -> Callable[[Array], Array]:
    """An expression as a function of the last axis of an array, complex arguments allowed."""
    plain = [sp.Symbol(f"s{i}") for i in range(len(symbols))]
    made = sp.lambdify(plain, sp.sympify(expression).xreplace(dict(zip(symbols, plain))), "numpy")  # noqa: B905

    def function(values: Array) -> Array:
        result = made(*np.moveaxis(values, -1, 0))
        return np.broadcast_to(result, values.shape[:-1]).astype(complex)

    return function


class Reference:
    """The same machine by other means, at given parameter values."""

    def __init__(self, system: System, **parameters: float) -> None:
        self.system = system
        self.values = {p.name: p.default for p in system.parameters}
        self.values |= dict(system.values) | parameters
        self.size = len(system.coordinates)
        self._known: dict[Any, Callable[[Array], Array]] = {}
        self.masses, self.places = self._point_masses()
        self.down = np.zeros(3)
        if system.gravity:
            self.down = np.array(system.gravity.down) * self.number(system.gravity.strength)

    def number(self, expression: Any) -> float:
        named = {p: self.values[p.name] for p in self.system.parameters}
        return float(sp.sympify(expression).xreplace(named))

    def _function(self, expression: Any, *, rates: bool = False) -> Callable[[Array], Array]:
        if (expression, rates) not in self._known:
            coordinates = [c for c in self.system.coordinates if isinstance(c, Coordinate)]
            symbols = coordinates + ([rate(c) for c in coordinates] if rates else [])
            named = {p: sp.Float(self.values[p.name], 17) for p in self.system.parameters}
            bound = sp.sympify(expression).xreplace(named)
            self._known[expression, rates] = compiled(bound, symbols)
        return self._known[expression, rates]

    def pose(self, frame: Frame, q: Array) -> tuple[Array, Array]:
        """Rotation (..., 3, 3) and position (..., 3) of a frame, for q of shape (..., nq)."""
        q = np.asarray(q)
        R = np.broadcast_to(np.eye(3), (*q.shape[:-1], 3, 3)).astype(complex)
        p = np.zeros((*q.shape[:-1], 3), complex)
        for motion in frame.motions:
            if isinstance(motion, Translation):
                by = np.stack([self._function(c)(q) for c in motion.by], axis=-1)
                p = p + (R @ by[..., None])[..., 0]
                continue
            assert isinstance(motion, Rotation)
            angle = self._function(motion.angle)(q)
            K = {
                "x": [[0, 0, 0], [0, 0, -1], [0, 1, 0]],
                "y": [[0, 0, 1], [0, 0, 0], [-1, 0, 0]],
                "z": [[0, -1, 0], [1, 0, 0], [0, 0, 0]],
            }[motion.axis]
            one, skew = np.eye(3), np.array(K, float)
            s, c = np.sin(angle)[..., None, None], np.cos(angle)[..., None, None]
            R = R @ (one + s * skew + (1 - c) * (skew @ skew))  # Rodrigues
        return R, p

    def _point_masses(self) -> tuple[Array, list[tuple[Body, Array]]]:
        masses, places = [], []
        for body in self.system.bodies:
            mass = self.number(body.mass)
            shell = mass or 1.0  # a body without mass: what turns is taken off again at the centre
            I, axes = self._principal_moments(body)  # noqa: E741
            squares = (
                1.5 / shell * (I.sum() - 2 * I)
            )  # of the distances, by the triangle inequality
            a = np.sqrt(np.maximum(squares, 0.0))[:, None] * axes.T
            masses += [*[shell / 6] * 6, mass - shell]
            places.append((body, np.concatenate([a, -a, np.zeros((1, 3))])))
        return np.array(masses), places

    def _principal_moments(self, body: Body) -> tuple[Array, Array]:
        """Moments (3,) and, as columns, the axes they are about (3, 3)."""
        xx, yy, zz, xy, xz, yz = (self.number(moment) for moment in body.inertia)
        moments, axes = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return moments, axes

    def points(self, q: Array) -> Array:
        """Where the point masses are, shape (..., 7 * bodies, 3)."""
        parts = []
        for body, offsets in self.places:
            R, p = self.pose(body.frame, q)
            parts.append(p[..., None, :] + np.einsum("...ij,kj->...ki", R, offsets))
        joined: Array = np.concatenate(parts, axis=-2)
        return joined

    def jacobian(self, function: Callable[[Array], Array], q: Array) -> Array:
        """Partial derivatives, shape (nq, ...)."""
        return np.array([taylor(function, q, d)[1] for d in np.eye(self.size)])

    def mass_matrix(self, q: Array) -> Array:
        J = self.jacobian(self.points, q)
        M: Array = np.einsum("ikx,jkx,k->ij", J, J, self.masses)
        return M

    def energy(self, q: Array, q_dot: Array) -> tuple[float, float]:
        points, speeds, _ = taylor(self.points, q, q_dot)
        kinetic = 0.5 * float(self.masses @ (speeds**2).sum(-1))
        return kinetic, -float(self.masses @ (points @ self.down))

    def balance(self, q: Array, q_dot: Array, u: Array) -> tuple[Array, Array]:
        """M (nq, nq) and what M q_ddot equals where nothing constrains the machine (nq,)."""
        J = self.jacobian(self.points, q)
        bend = taylor(self.points, q, q_dot)[2]
        M = np.einsum("ikx,jkx,k->ij", J, J, self.masses)
        force = np.einsum("ikx,kx,k->i", J, self.down - bend, self.masses)
        return M, force + self.input_matrix(q) @ np.asarray(u, float)

    def _unit_power(self, body: Body, entry: Any, axis: Axis, q: Array, along: Array) -> float:
        R, turned, _ = taylor(lambda s: self.pose(body.frame, s)[0], q, along)
        speed = self._speed_at(body, np.real(self.pose(entry.on.frame, q)[1]), q, along)
        direction = np.real(self.pose(axis.frame, q)[0])[:, "xyz".index(axis.name)]
        if isinstance(entry, Force):
            return float(direction @ speed)
        spin = turned @ R.T
        return float(direction @ [spin[2, 1], spin[0, 2], spin[1, 0]])

    def _speed_at(self, body: Body, place: Array, q: Array, along: Array) -> Array:
        """The velocity of the point of a body that is now at a place; reactions act there."""
        R, p = (np.real(part) for part in self.pose(body.frame, q))
        local = R.T @ (place - p)

        def point(at: Array) -> Array:
            turned, origin = self.pose(body.frame, at)
            moved: Array = origin + turned @ local
            return moved

        speed: Array = taylor(point, q, along)[1]
        return speed

    def unit_powers(self, q: Array, along: Array) -> Array:
        """The power of each input at the value 1 in a motion, shape (nu,)."""
        powers = []
        for entry in self.system.inputs:
            assert isinstance(entry, Torque | Force)
            axis = entry.along if isinstance(entry, Force) else entry.about
            total = self._unit_power(entry.on, entry, axis, q, along)
            if entry.reacts_on is not None:
                total -= self._unit_power(entry.reacts_on, entry, axis, q, along)
            powers.append(total)
        return np.array(powers)

    def input_matrix(self, q: Array) -> Array:
        """B, shape (nq, nu)."""
        rows = [self.unit_powers(q, d) for d in np.eye(self.size)]
        return np.array(rows).reshape(self.size, len(self.system.inputs))

    def covectors(self, q: Array) -> Array:
        """w(q), shape (..., constraints, nq), from the constraints' own expressions."""
        columns = []
        stated = [c.velocity for c in self.system.constraints if isinstance(c, VelocityConstraint)]
        for unit in np.eye(self.size):
            both = np.concatenate([q, np.broadcast_to(unit, q.shape)], axis=-1)
            rows = [self._function(velocity, rates=True)(both) for velocity in stated]
            columns.append(np.stack(rows, axis=-1))
        return np.stack(columns, axis=-1)

    def multiplier_form(self, q: Array, q_dot: Array, u: Array) -> tuple[Array, Array]:
        """q_ddot and lambda of M q_ddot = F + w^T lambda with d/dt (w q_dot) = 0."""
        M, force = self.balance(q, q_dot, u)
        if not self.system.constraints:
            return np.linalg.solve(M, force), np.zeros(0)
        w, change, _ = taylor(self.covectors, q, q_dot)
        count = len(w)
        matrix = np.block([[M, -w.T], [w, np.zeros((count, count))]])
        solved = np.linalg.solve(matrix, np.concatenate([force, -change @ q_dot]))
        return solved[: self.size], solved[self.size :]

    def full_rates(self, q: Array, v: Array, independent: Sequence[int]) -> Array:
        """q_dot from the independent rates, by least squares on the constraints."""
        q_dot = np.zeros(self.size)
        q_dot[list(independent)] = v
        if self.system.constraints:
            w = np.real(self.covectors(np.asarray(q, float)))
            dependent = [i for i in range(self.size) if i not in independent]
            q_dot[dependent] = np.linalg.lstsq(w[:, dependent], -w @ q_dot, rcond=None)[0]
        return q_dot
