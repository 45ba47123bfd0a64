"""A rapidly-exploring random tree in states and costs, below a bound of the cost; compiled.

Samples have a cost, too: a node is near one where its state is, and where its cost is. So a state
that was reached is reached again at less cost, and no node is kept from which the bound cannot be
kept.

Source: Hauser, Zhou, Asymptotically optimal planning by feasible kinodynamic planning in a
state-cost space, IEEE Transactions on Robotics 32(6), 2016.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.numerics.kd_forest import (
    KdForest,
    add,
    clear,
    kd_forest,
    nearest,
)
from kinolab.numerics.rng import uniform
from kinolab.search.tree.problem_arrays import (
    ProblemArrays,
    metric_coordinates,
    metric_periods,
    sample_state,
)
from kinolab.search.tree.rrt_kernel import extend, propagate
from kinolab.search.tree.tree import FULL, GROWING, REACHED, TOLERANCE_FRACTION, insert_node


class CostIndex(NamedTuple):
    """Nodes as points of states and costs, for compiled code."""

    forest: KdForest  # the last coordinate is the cost
    point: Array  # (d + 1,) scratch
    extent: float  # of all states, in scaled coordinates


def cost_index(arrays: ProblemArrays, capacity: int) -> CostIndex:
    """Return no nodes, with room for so many."""
    period = metric_periods(arrays)
    widths = (arrays.upper - arrays.lower)[arrays.entry] * arrays.weight
    across = np.where(np.isfinite(period), period / 2, widths)  # the farthest that two can be
    return CostIndex(
        forest=kd_forest(capacity, np.append(period, np.inf)),
        point=np.zeros(len(period) + 1),
        extent=float(np.linalg.norm(across)),
    )


@kernel
def locate(costs, point, cost):  # type: ignore[no-untyped-def]
    """Write a state's scaled coordinates and its cost to ``cost_index.point``."""
    for i in range(point.shape[0]):
        costs.point[i] = point[i]
    costs.point[point.shape[0]] = cost


@kernel
def begin_cost_index(search, tree, costs):  # type: ignore[no-untyped-def]
    """Leave nothing but the start, which is node 0."""
    clear(costs.forest)
    metric_coordinates(search.problem, search.problem.start, tree.point)
    locate(costs, tree.point, 0.0)
    add(costs.forest, costs.point)


@kernel
def grow_below(  # type: ignore[no-untyped-def]
    search, tree, costs, best, iterations, most, cost_weight,
    goal_bias, control_samples, min_steps, max_steps,
):  # fmt: skip
    """Grow a tree by some iterations.

    Args:
        search: The problem, and scratch memory.
        tree: Grows, but for its own neighbours.
        costs: Of the tree.
        best: The node nearest to the goal, and its excess (2,); written.
        iterations: How many at most.
        most: Steps that a motion into the goal must fall below.
        cost_weight: How far so many steps are apart, in extents of all states.
        goal_bias: Probability of growing to the goal.
        control_samples: Inputs of which that one is held which leads nearest.
        min_steps, max_steps: For how many steps an input is held.

    Returns:
        How it ended, and how many iterations were made.
    """
    arrays, random, per_step = search.problem, search.random, cost_weight * costs.extent / most
    for done in range(iterations):
        if tree.size[0] >= tree.x.shape[0]:
            return FULL, done
        sample_state(arrays, random, goal_bias, tree.target)
        metric_coordinates(arrays, tree.target, tree.aim)
        locate(costs, tree.aim, uniform(random) * most * per_step)
        parent, _ = nearest(costs.forest, costs.point, 0, math.inf)
        if uniform(random) * (1.0 + tree.failures[parent]) > 1.0:
            continue
        longest = propagate(search, tree, parent, min_steps, max_steps, control_samples)
        longest = min(longest, most - 1 - tree.cost[parent])
        made, violation, known_clearance = extend(search, tree, parent, min_steps, longest, best[1])
        cost = tree.cost[parent] + made
        if made < min_steps or (cost + 1 >= most and violation > TOLERANCE_FRACTION):
            tree.failures[parent] += 1
            continue
        node = insert_node(tree, tree.now, tree.held, parent, made, known_clearance)
        metric_coordinates(arrays, tree.now, tree.point)
        locate(costs, tree.point, cost * per_step)
        add(costs.forest, costs.point)
        if violation < best[1]:
            best[0], best[1] = node, violation
        if violation <= TOLERANCE_FRACTION:
            return REACHED, done + 1
    return GROWING, iterations
