"""Maneuvers: states and inputs over equal time steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array


@dataclass(frozen=True, eq=False)
class Maneuver:
    """States and zero-order-hold inputs, one per propagation step.

    Attributes:
        x: States, shape (N+1, nx); angles are continuous.
        u: Inputs, shape (N, nu).
    """

    x: Array
    u: Array

    @property
    def steps(self) -> int:
        """Number of propagation steps."""
        return len(self.u)

    def then(self, other: Maneuver) -> Maneuver:
        """Concatenate with another maneuver that begins where this one ends."""
        return Maneuver(np.vstack([self.x[:-1], other.x]), np.vstack([self.u, other.u]))
