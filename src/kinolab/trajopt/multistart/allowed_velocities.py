"""Velocities that a machine's constraints allow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.trajopt.nlp.options import GUESS


def velocity_directions(problem: PlanningTask, x: Array, coordinates: NDArray[np.int64]) -> Array:
    """Return coordinate rates that span those allowed, shape (m, coordinates, directions).

    They are the Jacobian in the velocities, or where inputs are the velocities, the rates at
    corners of their range: those beside the lowest and the highest one.
    """
    model, (m, nx) = problem.model, x.shape
    if model.nq == nx:
        one, (lower, upper) = (
            np.eye(model.nu, dtype=bool),
            np.clip(model.control_bounds.T, -1e3, 1e3),
        )
        corners = np.vstack([np.where(one, upper, lower), np.where(one, lower, upper)])
        states, inputs = np.repeat(x, len(corners), axis=0), np.tile(corners, (m, 1))
        rates = model.f(states, inputs).reshape(m, len(corners), nx)[:, :, coordinates]
        return np.swapaxes(rates, 1, 2)
    one_by_one = np.vstack([np.zeros(nx), np.eye(nx)[model.nq :]])
    states = np.repeat(x[:, None], len(one_by_one), axis=1)
    states[:, :, model.nq :] = 0.0
    states = (states + one_by_one).reshape(-1, nx)
    idle = np.clip(model.control_bounds, -1e3, 1e3).mean(axis=1)
    rates = model.f(states, np.tile(idle, (len(states), 1))).reshape(m, -1, nx)[:, :, coordinates]
    return np.swapaxes(rates[:, 1:] - rates[:, :1], 1, 2)


def velocities_along(
    problem: PlanningTask, x: Array, rates: Array, coordinates: NDArray[np.int64]
) -> Array:
    """Return the velocities whose coordinate rates are nearest to those wanted, shape (m, nv).

    Args:
        problem: The planning problem; nearest is by its scales.
        x: States, shape (m, nx).
        rates: Wanted, per [s], shape (m, coordinates) or (coordinates,).
        coordinates: Which of them.
    """
    large = problem.scales[coordinates]
    J = velocity_directions(problem, x, coordinates) / large[:, None]
    inverse = np.linalg.pinv(J, rcond=GUESS.rank_tolerance)
    nearest: Array = (inverse @ (rates / large)[..., None])[..., 0]
    return nearest
