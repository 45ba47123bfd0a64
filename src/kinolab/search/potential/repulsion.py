"""What pushes bodies off obstacles.

Source: Khatib, Real-time obstacle avoidance for manipulators and mobile robots, IJRR 5(1), 1986.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinolab.world.collision.closest_points import Gap
from kinolab.world.geometry import Array

MIN_DISTANCE = 1e-4  # [m]; nearer than this the push grows no more, so that it stays a number


@dataclass(frozen=True)
class Repulsion:
    """A potential gain / 2 (1/d - 1/reach)^2 of a gap d, and 0 beyond the reach.

    Attributes:
        gain: In [m^3], so that the potential is in [m].
        reach: Range of influence in [m].
    """

    gain: float
    reach: float

    def potential(self, distance: float) -> float:
        """Return the potential in [m] at a distance in [m]; infinite at contact."""
        if distance <= 0:
            return math.inf
        if distance >= self.reach:
            return 0.0
        return 0.5 * self.gain * (1 / max(distance, MIN_DISTANCE) - 1 / self.reach) ** 2

    def force(self, gap: Gap) -> Array:
        """Return the push on the body at its nearest point, away from the obstacle, shape (3,).

        Its length is gain (1/d - 1/reach) / d^2; it is 0 at contact, where no direction is known.
        """
        d = max(gap.distance, MIN_DISTANCE)
        if not 0 < gap.distance < self.reach:
            return np.zeros(3)
        away = (gap.on_body - gap.on_obstacle) / gap.distance
        push: Array = self.gain * (1 / d - 1 / self.reach) / d**2 * away
        return push
