"""A motion that was followed through the full dynamics, or one that is yet to be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array


@dataclass(frozen=True, eq=False)
class Maneuver:
    """Inputs held for one propagation step each, and the states between them.

    Attributes:
        x: States, shape (N+1, nx); angles are continuous.
        u: Inputs, shape (N, nu).
    """

    x: Array
    u: Array

    @property
    def steps(self) -> int:
        """How many propagation steps it takes."""
        return len(self.u)

    def then(self, other: Maneuver) -> Maneuver:
        """Return this maneuver followed by another, which begins where this one ends."""
        return Maneuver(np.vstack([self.x[:-1], other.x]), np.vstack([self.u, other.u]))
