"""Configurations in which points and axes of bodies are where the goal wants them."""

from __future__ import annotations

import numpy as np

from kinolab.dynamics import Model
from kinolab.numerics.arrays import Array
from kinolab.problem.goal import Goal


def reaching(
    model: Model, goal: Goal, x: Array, offsets: Array, *, scales: Array, limits: Array
) -> Array:
    """Return states (n, nx) moved so that points and axes of bodies reach their targets.

    Each is moved as little as it takes, as ``scales`` count; what the goal states of entries and
    attitudes stays, and so do velocities. Targets out of reach are approached.

    Args:
        model: The machine; without closed loops, whose constraints are not kept here.
        x: States, shape (n, nx).
        offsets: Where each point is wanted besides its target, in [m], shape (n, points, 3).
        scales: Characteristic magnitude of each entry, shape (nx,).
        limits: Lower and upper limit of each entry, shape (nx, 2).

    Source: Wampler, Manipulator inverse kinematic solutions based on vector formulations and
    damped least-squares methods, IEEE Trans. Systems, Man, and Cybernetics 16(1), 1986.
    """
    free = np.zeros(model.nx, dtype=bool)
    free[: model.nq] = True
    free[goal.entries] = False
    widths = np.where(free, scales, 0.0)
    reached, rows = x.copy(), np.arange(len(x))
    for _ in range(40):  # damped steps of Newton's method
        gap = _gap(model, goal, reached[rows], offsets[rows])
        apart = np.abs(gap).max(axis=1, initial=0.0) > 1e-9  # [m] and [rad] from the targets
        rows, gap = rows[apart], gap[apart]
        if not len(rows):
            break
        J = _jacobian(model, goal, reached[rows]) * widths
        A = J @ J.swapaxes(1, 2)
        size = np.trace(A, axis1=1, axis2=2)[:, None, None]
        # Where nothing changes any gap, as a formula's at its extremum, no step is made.
        # of the squared singular values: bounds steps near singular poses
        damped = A + np.where(size > 0.0, 1e-6 * size, 1.0) * np.eye(A.shape[1])
        step = -(J.swapaxes(1, 2) @ np.linalg.solve(damped, gap[..., None]))[..., 0]
        longest = np.abs(step).max(axis=1, keepdims=True)
        # half a characteristic magnitude at most: the linearisation holds no longer
        step *= widths * (0.5 / np.maximum(longest, 0.5))
        reached[rows] = model.space.unit(np.clip(reached[rows] + step, *limits.T))
        # step of a coordinate, relative to its magnitude: no nearer any more
        rows = rows[longest[:, 0] > 1e-9]
    return reached


def _gap(model: Model, goal: Goal, x: Array, offsets: Array) -> Array:
    """Return how far points and axes are from where they are wanted, shape (n, 3 targets)."""
    frames = model.frames(x)
    points = [target.offset(frames) - offsets[:, k] for k, target in enumerate(goal.points)]
    others = (one.offset(frames) for one in goal.of_bodies[len(points) :])
    return np.concatenate([*points, *others], axis=1)


def _jacobian(model: Model, goal: Goal, x: Array) -> Array:
    """Return the derivatives of the gaps by the entries of the states, (n, 3 targets, nx)."""
    columns = np.moveaxis(model.frames_jacobian(x), -1, 0)
    slopes = [target.in_world(columns) for target in goal.of_bodies]
    return np.moveaxis(np.concatenate(slopes, axis=-1), 0, -1)
