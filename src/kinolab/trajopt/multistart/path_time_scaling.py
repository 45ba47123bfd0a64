"""With which speeds a machine follows a way through its configurations, as far as it can.

The rates of coordinates are linear in a machine's velocities: those are taken that come nearest.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import Problem
from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.options import GUESS

Array: TypeAlias = NDArray[np.float64]


def path_time_scaling(problem: Problem, knots: Knots) -> Knots:
    """Return knots whose speeds lead from one configuration to the next, as far as possible.

    The first and the last one stay as they are.

    Args:
        problem: With the machine.
        knots: Coordinates along a way, and any speeds.
    """
    x, nq = knots.x.copy(), problem.model.nq
    if len(x) < 3 or nq == x.shape[1]:
        return knots
    matters = np.flatnonzero(~cyclic_coordinates(problem)[:nq])
    large = problem.scales[matters]
    rates = (x[2:, matters] - x[:-2, matters]) / (2 * knots.h) / large
    possible = np.linalg.pinv(
        _directions(problem, x[1:-1], matters) / large[:, None], rcond=GUESS.rank_tolerance
    )
    speeds = (possible @ rates[..., None])[..., 0]
    x[1:-1, nq:] = np.clip(speeds, *problem.bounds[nq:].T)
    return Knots(x, knots.u, knots.h)


def _directions(problem: Problem, x: Array, coordinates: NDArray[np.int64]) -> Array:
    """Return the rates of coordinates for each speed, shape (m, coordinates, speeds)."""
    model, (m, nx) = problem.model, x.shape
    one_by_one = np.vstack([np.zeros(nx), np.eye(nx)[model.nq :]])
    states = np.repeat(x[:, None], len(one_by_one), axis=1)
    states[:, :, model.nq :] = 0.0
    states = (states + one_by_one).reshape(-1, nx)
    idle = np.clip(model.control_bounds, -1e3, 1e3).mean(axis=1)
    rates = model.f(states, np.tile(idle, (len(states), 1))).reshape(m, -1, nx)[:, :, coordinates]
    return np.swapaxes(rates[:, 1:] - rates[:, :1], 1, 2)
