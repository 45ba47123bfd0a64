"""States on the way from knot to knot, where inequalities are looked at."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.nlp.linear_inequalities import LinearInequalities

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Samples:
    """States on the straight lines between knots.

    Attributes:
        knot: After which they come, shape (m,).
        share: Of the way to the next knot, in [0, 1], shape (m,).
        x: States, shape (m, nx).
        u: Inputs held there, shape (m, nu).
    """

    knot: NDArray[np.int64]
    share: Array
    x: Array
    u: Array

    def rows(
        self, which: NDArray[np.int64], value: Array, dx: Array, du: Array
    ) -> LinearInequalities:
        """Return inequalities whose derivatives at some of the samples are known.

        Args:
            which: Sample of each inequality, shape (n,).
            value: Shape (n,).
            dx: Derivative with respect to the sample's state, shape (n, nx).
            du: With respect to its inputs, shape (n, nu).
        """
        fraction = self.share[which][:, None]
        return LinearInequalities(self.knot[which], value, (1 - fraction) * dx, fraction * dx, du)


def samples(knots: Knots, pieces: int) -> Samples:
    """Return so many states per step, evenly spaced, the start left out."""
    steps = len(knots.u)
    knot = np.repeat(np.arange(steps), pieces)
    fraction = np.tile(np.arange(1, pieces + 1) / pieces, steps)
    x = knots.x[:-1][knot] * (1 - fraction)[:, None] + knots.x[1:][knot] * fraction[:, None]
    return Samples(knot, fraction, x, knots.u[knot])


def beginnings(knots: Knots) -> Samples:
    """Return the state at the beginning of each step, under the inputs that are held from there."""
    steps = len(knots.u)
    return Samples(np.arange(steps), np.zeros(steps), knots.x[:-1], knots.u)
