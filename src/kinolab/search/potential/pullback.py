"""Pullback of point forces to generalised forces, and their projection onto inputs.

Source: Khatib, A unified approach for motion and force control of robot manipulators: the
operational space formulation, IEEE J. Robotics and Automation 3(1), 1987; the least squares are
Gauss's principle of least constraint, as in Udwadia, Kalaba, Analytical Dynamics, 1996.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics import Model
from kinolab.numerics.arrays import Array
from kinolab.numerics.bounded_lsq import bounded_least_squares
from kinolab.search.potential.field import PointForce


def independent_entries(model: Model) -> slice:
    """Return the slice of the independent velocities in the state."""
    return slice(model.nq, model.nq + model.nv)


def velocity_columns(model: Model, x: Array) -> tuple[Array, Array]:
    """Return the Jacobians of rates and velocities in the independent velocities v.

    Returns:
        d(q_dot)/dv in the entries of the configuration, shape (nq, nv), and d(nu)/dv among all
        velocities, shape (nt, nv). Both are exact: the relation is linear.
    """
    entries = independent_entries(model)
    count = entries.stop - entries.start
    states = np.tile(x, (count + 1, 1))
    states[:, entries] = np.eye(count + 1, count)  # the last one is at rest
    rates, all_velocities = model.f(states)[:, : model.nq], model.velocity(states)
    return (rates[:-1] - rates[-1]).T, (all_velocities[:-1] - all_velocities[-1]).T


def point_jacobians(model: Model, x: Array, points: Sequence[tuple[int, Array]]) -> Array:
    """Return the Jacobians of body points in the independent velocities.

    Args:
        x: State, shape (nx,).
        points: Body index and world point fixed to it, shape (3,).

    Returns:
        Shape (points, 3, nv).
    """
    columns = velocity_columns(model, x)[0]
    poses = model.frames(x).reshape(-1, 3, 4)
    slopes = (model.frames_jacobian(x)[..., : model.nq] @ columns).reshape(len(poses), 3, 4, -1)
    found = np.zeros((len(points), 3, columns.shape[1]))
    for k, (body, at) in enumerate(points):
        here = poses[body]
        local = np.append(here[:, :3].T @ (at - here[:, 3]), 1.0)
        found[k] = np.einsum("ijk,j->ik", slopes[body], local)
    return found


def generalised_force(jacobians: Array, forces: Sequence[PointForce]) -> Array:
    """Return the generalised force, the sum of J^T f over points, shape (nv,)."""
    stacked = np.array([force.force for force in forces]).reshape(-1, 3)
    force: Array = np.einsum("kij,ki->j", jacobians, stacked)
    return force


def reduced_mass(model: Model, x: Array) -> Array:
    """Return the mass matrix reduced to the independent velocities, shape (nv, nv).

    Raises:
        NoDynamicsError: If the machine is kinematic.
    """
    columns = velocity_columns(model, x)[1]
    reduced: Array = columns.T @ model.mass_matrix(x) @ columns
    return reduced


@dataclass(frozen=True)
class InputProjection:
    """Projects desired accelerations onto the inputs.

    Attributes:
        model: The machine.
        pull: Acceleration of the control points in [m/s^2] for a unit gradient of the potential.
        damping: Decay rate in [1/s] of velocities in the absence of force.
    """

    model: Model
    pull: float
    damping: float

    def inputs(self, x: Array, forces: Sequence[PointForce], pulls: int) -> Array:
        """Return inputs within their limits, shape (nu,).

        A fully actuated machine would accelerate by M^-1 F - damping v. The inputs bring the
        acceleration nearest to that in the metric of M.

        Args:
            x: State, shape (nx,).
            forces: On points of the bodies.
            pulls: Number of leading forces that are attractive; they set the scale of the force.

        Raises:
            NoDynamicsError: If the machine is kinematic.
            SingularError: If the equations of motion have no unique solution.
        """
        model, entries = self.model, independent_entries(self.model)
        jacobians = point_jacobians(model, x, [(force.body, force.at) for force in forces])
        mass = reduced_mass(model, x)
        attracted = generalised_force(jacobians[:pulls], forces[:pulls])
        force = generalised_force(jacobians, forces)
        mobility = float(attracted @ np.linalg.solve(mass, attracted))
        steepness = sum(float(f.force @ f.force) for f in forces[:pulls])
        scale = self.pull * steepness / mobility if mobility > 1e-12 else 0.0
        wanted = np.linalg.solve(mass, scale * force) - self.damping * x[entries]
        return self.nearest_inputs(x, mass, wanted)

    def nearest_inputs(self, x: Array, mass: Array, wanted: Array) -> Array:
        """Return the inputs (nu,) whose accelerations are nearest to those wanted (nv,)."""
        model, entries = self.model, independent_entries(self.model)
        lower, upper = model.control_bounds.T
        middle = (lower + upper) / 2
        drift = model.f(x, middle)[entries]
        slopes = model.jacobian(x, middle)[1][entries]
        root = np.linalg.cholesky(mass).T
        change = bounded_least_squares(
            root @ slopes, root @ (wanted - drift), lower - middle, upper - middle
        )
        inputs: Array = middle + change
        return inputs
