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

from kinolab.numerics.jit import kernel
from kinolab.numerics.kd_forest import Array, Forest, add, clear, forest, nearest
from kinolab.numerics.rng import uniform
from kinolab.search.tree.problem_arrays import Question, draw_state, period_of, scaled
from kinolab.search.tree.rrt_kernel import held_for, move
from kinolab.search.tree.tree import FULL, GROWING, INSIDE, REACHED, insert_node


class Costs(NamedTuple):
    """Nodes as points of states and costs, for compiled code."""

    forest: Forest  # the last coordinate is the cost
    point: Array  # (d + 1,) scratch
    extent: float  # of all states, in scaled coordinates


def costs(question: Question, capacity: int) -> Costs:
    """Return no nodes, with room for so many."""
    period = period_of(question)
    widths = (question.highest - question.lowest)[question.entry] * question.weight
    across = np.where(np.isfinite(period), period / 2, widths)  # the farthest that two can be
    return Costs(
        forest=forest(capacity, np.append(period, np.inf)),
        point=np.zeros(len(period) + 1),
        extent=float(np.linalg.norm(across)),
    )


@kernel
def locate(costs, point, cost):  # type: ignore[no-untyped-def]
    """Write a state's scaled coordinates and its cost to ``costs.point``."""
    for i in range(point.shape[0]):
        costs.point[i] = point[i]
    costs.point[point.shape[0]] = cost


@kernel
def begin_costs(search, tree, costs):  # type: ignore[no-untyped-def]
    """Leave nothing but the start, which is node 0."""
    clear(costs.forest)
    scaled(search.question, search.question.start, tree.point)
    locate(costs, tree.point, 0.0)
    add(costs.forest, costs.point)


@kernel
def grow_below(  # type: ignore[no-untyped-def]
    search, tree, costs, best, iterations, most, cost_weight,
    goal_bias, tried, min_steps, max_steps,
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
        tried: Inputs of which that one is held which leads nearest.
        min_steps, max_steps: For how many steps an input is held.

    Returns:
        How it ended, and how many iterations were made.
    """
    question, random, per_step = search.question, search.random, cost_weight * costs.extent / most
    for done in range(iterations):
        if tree.size[0] >= tree.x.shape[0]:
            return FULL, done
        draw_state(question, random, goal_bias, tree.target)
        scaled(question, tree.target, tree.aim)
        locate(costs, tree.aim, uniform(random) * most * per_step)
        parent, _ = nearest(costs.forest, costs.point, 0, math.inf)
        if uniform(random) * (1.0 + tree.failures[parent]) > 1.0:
            continue
        longest = held_for(search, tree, parent, min_steps, max_steps, tried)
        longest = min(longest, most - 1 - tree.cost[parent])
        made, share, spare = move(search, tree, parent, min_steps, longest, best[1])
        cost = tree.cost[parent] + made
        if made < min_steps or (cost + 1 >= most and share > INSIDE):
            tree.failures[parent] += 1
            continue
        node = insert_node(tree, tree.now, tree.held, parent, made, spare)
        scaled(question, tree.now, tree.point)
        locate(costs, tree.point, cost * per_step)
        add(costs.forest, costs.point)
        if share < best[1]:
            best[0], best[1] = node, share
        if share <= INSIDE:
            return REACHED, done + 1
    return GROWING, iterations
