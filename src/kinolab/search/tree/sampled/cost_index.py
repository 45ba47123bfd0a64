"""Index of nodes by state and cost.

Source: Hauser, Zhou, Asymptotically optimal planning by feasible kinodynamic planning in a
state-cost space, IEEE Transactions on Robotics 32(6), 2016.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.numerics.neighbours.r_tree import RTree, r_tree
from kinolab.search.tree.flat_arrays import copy
from kinolab.search.tree.problem_arrays import ProblemArrays, metric_periods


class CostIndex(NamedTuple):
    """Nodes as points in state-cost space, for compiled kernels."""

    neighbours: RTree  # the last coordinate is the cost
    point: Array  # (d + 1,) scratch
    extent: float  # diameter of the state space, in scaled coordinates


def cost_index(arrays: ProblemArrays, capacity: int) -> CostIndex:
    """Allocate an empty index with a capacity in nodes."""
    period = metric_periods(arrays)
    widths = (arrays.upper - arrays.lower)[arrays.entry] * arrays.weight
    across = np.where(np.isfinite(period), period / 2, widths)  # largest distance
    return CostIndex(
        neighbours=r_tree(capacity, np.append(period, np.inf)),
        point=np.zeros(len(period) + 1),
        extent=float(np.linalg.norm(across)),
    )


@kernel
def locate(costs, point, cost):  # type: ignore[no-untyped-def]
    """Write scaled coordinates (d,) and a cost to ``costs.point``, shape (d + 1,)."""
    copy(point, costs.point)
    costs.point[point.shape[0]] = cost
