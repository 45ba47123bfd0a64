"""What pulls a control point to its goal when nothing is known of the obstacles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array


@dataclass(frozen=True, eq=False)
class StraightLinePotential:
    """The distance to a goal, rounded off beside it: a cone that ends in a paraboloid.

    Attributes:
        goal: In the world, in [m], shape (3,).
        rounding: Distance in [m] below which the pull fades.

    Source: Latombe, Robot Motion Planning, 1991, section 7.1.
    """

    goal: Array
    rounding: float = 0.1

    def __call__(self, points: Array) -> tuple[Array, Array]:
        """Return values (n,) in [m] and gradients (n, 3) at points (n, 3)."""
        away = points - self.goal
        distance = np.linalg.norm(away, axis=1)
        near = distance < self.rounding
        value = np.where(near, distance**2 / (2 * self.rounding), distance - self.rounding / 2)
        return value, away / np.maximum(distance, self.rounding)[:, None]
