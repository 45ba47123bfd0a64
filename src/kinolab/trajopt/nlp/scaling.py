"""What counts as large, what is allowed, and what a trajectory costs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Scaling:
    """What counts as large, and what is allowed.

    Attributes:
        x: Shape (nx,).
        u: Shape (nu,).
        x_bounds: Lower and upper limits, shape (nx, 2).
        u_bounds: Shape (nu, 2).
        h_bounds: Shortest and longest step in [s].
    """

    x: Array
    u: Array
    x_bounds: Array
    u_bounds: Array
    h_bounds: tuple[float, float]


@dataclass(frozen=True)
class Weights:
    """What a trajectory costs.

    Attributes:
        time: Of its duration, per [s].
        effort: Of the mean square of its inputs, as shares of their limits.
        stay: Of the mean square change of states and inputs, as shares of what counts as large.
        penalty: Of what is missing: defects, goal and inequalities.
    """

    time: float
    effort: float
    stay: float
    penalty: float
