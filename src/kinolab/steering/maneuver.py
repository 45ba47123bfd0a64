"""Maneuvers: states and inputs over equal time steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.concurrency.cancel import CancellationToken, raise_if_cancelled
from kinolab.numerics.arrays import Array
from kinolab.simulation import Propagator

STEPS_PER_CANCELLATION_CHECK = 16


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

    def is_free(self, judge: Propagator, stop: CancellationToken) -> bool:
        """Check every step for limits, requirements and obstacles.

        Raises:
            CancelledError: If ``stop`` is set.
        """
        for k, (x, u) in enumerate(zip(self.x.tolist(), self.u.tolist(), strict=False)):
            if k % STEPS_PER_CANCELLATION_CHECK == 0:
                raise_if_cancelled(stop)
            if not judge.step(x, u, judge.problem.step)[1]:
                return False
        return True
