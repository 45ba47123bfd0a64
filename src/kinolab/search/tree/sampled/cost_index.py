"""AO-RRT kernel: a rapidly-exploring random tree in state-cost space, below a cost bound.

Samples include a cost, and nearest neighbours are found in state and cost together. So states that
were reached are reached again at lower cost, and nodes that cannot meet the bound are discarded.

Source: Hauser, Zhou, Asymptotically optimal planning by feasible kinodynamic planning in a
state-cost space, IEEE Transactions on Robotics 32(6), 2016.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.numerics.neighbours.insertion import add
from kinolab.numerics.neighbours.queries import nearest
from kinolab.numerics.neighbours.r_tree import RTree, clear, r_tree
from kinolab.numerics.rng import uniform
from kinolab.search.tree.extensions import (
    begin_extension,
    end_extension,
    has_ended,
    lane_to_serve,
)
from kinolab.search.tree.problem_arrays import (
    ProblemArrays,
    is_inside,
    metric_coordinates,
    metric_periods,
    sample_state,
)
from kinolab.search.tree.sampled.directed_control import directed_control, is_tried
from kinolab.search.tree.tree import (
    FULL,
    GROWING,
    NONE,
    insert_node,
    note_nearest,
)


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
    for i in range(point.shape[0]):
        costs.point[i] = point[i]
    costs.point[point.shape[0]] = cost


@kernel
def begin_cost_index(search, tree, costs):  # type: ignore[no-untyped-def]
    """Clear the index to the start, node 0."""
    clear(costs.neighbours)
    metric_coordinates(search.problem, search.problem.start, tree.point)
    locate(costs, tree.point, 0.0)
    add(costs.neighbours, costs.point)


@kernel
def grow_below(  # type: ignore[no-untyped-def]
    search, tree, costs, best, iterations, most, cost_weight,
    goal_bias, control_samples, min_steps, max_steps,
):  # fmt: skip
    """Grow a tree for some iterations.

    Args:
        search: The problem and scratch memory.
        tree: The tree, whose own index is not used; written.
        costs: Index of its nodes; written.
        best: The node nearest to the goal and its normalised goal error (2,); written.
        iterations: Maximum number of iterations.
        most: Cost bound: steps that a solution must stay below.
        cost_weight: Distance of that many steps in the metric, in diameters of the state space.
        goal_bias: Probability of sampling the goal.
        control_samples: Number of candidate inputs, of which the one leading nearest is applied.
        min_steps, max_steps: Range of the control duration in steps.

    Returns:
        GROWING, REACHED or FULL, and the number of iterations made.
    """
    per_step = cost_weight * costs.extent / most
    done = 0
    while True:
        lane = lane_to_serve(search, tree, min_steps, best[1])
        if has_ended(tree, lane):
            status = settle_below(search, tree, costs, lane, best, min_steps, most, per_step)
            if status != GROWING:
                return status, done
            continue
        if done >= iterations:
            return GROWING, done
        done += 1
        tree.extensions.draws[lane] += 1
        parent = draw_below(search, tree, costs, goal_bias, most, per_step)
        if parent != NONE:
            steps = directed_control(search, tree, parent, min_steps, max_steps, control_samples)
            steps = min(steps, most - 1 - tree.cost[parent])
            begin_extension(search, tree, lane, parent, steps)


@kernel
def settle_below(search, tree, costs, lane, best, min_steps, most, per_step):  # type: ignore[no-untyped-def]
    """Add the end of an extension to the tree if it can meet the cost bound.

    Args:
        search, tree, costs: ``SearchState``, ``Tree`` and ``CostIndex``.
        lane: Where it has ended.
        best: The node nearest to the goal and its normalised goal error (2,); written.
        most: Cost bound, as ``grow_below`` takes it.
        min_steps: Fewest steps that are kept.
        per_step: Distance of a step in the metric.

    Returns:
        GROWING, REACHED or FULL.
    """
    if tree.size[0] >= tree.x.shape[0]:
        return FULL
    parent, made, violation, known_clearance = end_extension(tree, lane)
    cost = tree.cost[parent] + made
    if made < min_steps or (cost + 1 >= most and not is_inside(violation)):
        tree.failures[parent] += 1
        return GROWING
    node = insert_node(tree, tree.now, tree.held, parent, made, known_clearance)
    metric_coordinates(search.problem, tree.now, tree.point)
    locate(costs, tree.point, cost * per_step)
    add(costs.neighbours, costs.point)
    return note_nearest(best, node, violation)


@kernel
def draw_below(search, tree, costs, goal_bias, most, per_step):  # type: ignore[no-untyped-def]
    """Return the node to extend, nearest to a sample of state and cost, or NONE.

    Args:
        search, tree, costs: ``SearchState``, ``Tree`` and ``CostIndex``.
        goal_bias: Probability of sampling the goal.
        most, per_step: Cost bound in steps, and the distance of a step in the metric.
    """
    sample_state(search.problem, search.random, goal_bias, tree.target)
    metric_coordinates(search.problem, tree.target, tree.aim)
    locate(costs, tree.aim, uniform(search.random) * most * per_step)
    parent, _ = nearest(costs.neighbours, costs.point, 0, math.inf)
    return parent if is_tried(search, tree, parent) else NONE
