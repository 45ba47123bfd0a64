"""The configurations of a machine as a space of OMPL, whose distances are metres of motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import Problem
from kinolab.search.ompl.spaces import StateCodec


class Configurations(StateCodec):
    """All coordinates that move the machine; the others stay as at the start.

    Args:
        problem: The machine and its limits.
        reach: Metres that each coordinate moves the machine by, per unit, shape (nx,).
        resolution: In [m] of motion between two looks at it.
    """

    def __init__(self, problem: Problem, reach: Array, resolution: float) -> None:
        entries = [int(i) for i in np.flatnonzero(reach)]
        super().__init__(replace(problem, weights=reach), entries)
        for k in range(self.space.getSubspaceCount()):
            part = self.space.getSubspace(k)
            extent = self.space.getSubspaceWeight(k) * part.getMaximumExtent()
            part.setLongestValidSegmentFraction(min(max(resolution / extent, 1e-6), 0.5))
