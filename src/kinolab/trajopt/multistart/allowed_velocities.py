"""Velocities that a machine's constraints allow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask


def velocity_directions(problem: PlanningTask, x: Array, coordinates: NDArray[np.int64]) -> Array:
    """Jacobian of coordinate rates in the velocities, shape (m, coordinates, velocities)."""
    model, (m, nx) = problem.model, x.shape
    one_by_one = np.vstack([np.zeros(nx), np.eye(nx)[model.nq :]])
    states = np.repeat(x[:, None], len(one_by_one), axis=1)
    states[:, :, model.nq :] = 0.0
    states = (states + one_by_one).reshape(-1, nx)
    idle = np.clip(model.control_bounds, -1e3, 1e3).mean(axis=1)
    rates = model.f(states, np.tile(idle, (len(states), 1))).reshape(m, -1, nx)[:, :, coordinates]
    return np.swapaxes(rates[:, 1:] - rates[:, :1], 1, 2)
