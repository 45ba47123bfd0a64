"""The coin that rolls through the maze, with less friction than it has by itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import kinolab
from kinolab.problem import PlanningTask

Array = NDArray[np.float64]

MASS, RADIUS, FRICTION, GRAVITY = 1.0, 0.25, 0.4, 9.81


def grip(x: Array, u: Array) -> Array:
    """Return what is left of the squared friction in [N^2], in closed form.

    Sideways the rim gives m v psi_dot; along its way m a, and a = drive / (3/2 m R).

    Args:
        x: States (m, 6): x, y, psi, phi, psi_dot, phi_dot.
        u: Inputs (m, 2): drive, steer.
    """
    sideways = MASS * RADIUS * x[:, 5] * x[:, 4]
    along = u[:, 0] / (1.5 * RADIUS)
    return np.asarray((FRICTION * MASS * GRAVITY) ** 2 - sideways**2 - along**2)


def gripping_maze(*overrides: str) -> PlanningTask:
    """Return the maze of README with that coin."""
    friction = f"system.parameters.mu={FRICTION}"
    return kinolab.load("rolling_disk_maze", overrides=[friction, *overrides])
