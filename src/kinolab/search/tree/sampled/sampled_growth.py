"""Growth toward samples: the loop of RRT, SST and AO-RRT.

They differ in the node that a sample chooses, and in the ends of extensions that become nodes.

RRT extends the nearest node, and keeps all ends. SST extends the cheapest one of a sparse tree, and
keeps an end if its witness has no cheaper node. AO-RRT is RRT until there is a cost bound; then its
samples include a cost, nearest neighbours are found in state and cost together, so that states that
were reached are reached again at lower cost, and ends that cannot meet the bound are discarded.

Source: LaValle, Kuffner, Randomized kinodynamic planning, IJRR 20(5), 2001; Li, Littlefield,
Bekris, Asymptotically optimal sampling-based kinodynamic planning, IJRR 35(5), 2016; Hauser, Zhou,
Asymptotically optimal planning by feasible kinodynamic planning in a state-cost space, IEEE
Transactions on Robotics 32(6), 2016.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.numerics.neighbours.insertion import add
from kinolab.numerics.neighbours.queries import nearest
from kinolab.numerics.neighbours.r_tree import RTree, clear, r_tree
from kinolab.numerics.rng import uniform
from kinolab.search.tree.extensions import (
    Ends,
    begin_extension,
    end_extension,
    has_ended,
    keep_end,
    lane_to_serve,
)
from kinolab.search.tree.flat_arrays import copy
from kinolab.search.tree.problem_arrays import (
    ProblemArrays,
    is_inside,
    metric_coordinates,
    metric_periods,
    sample_state,
)
from kinolab.search.tree.sampled.directed_control import directed_control
from kinolab.search.tree.sampled.witnesses import (
    NOBODY,
    Witnesses,
    represent,
    select,
    sweep,
    witness_at,
)
from kinolab.search.tree.search_state import SearchState
from kinolab.search.tree.tree import (
    FULL,
    GROWING,
    NONE,
    Tree,
    begin_tree,
    cost_at,
    insert_node,
    note_nearest,
)
from kinolab.search.tree.tree_extension import UNBOUNDED_STEPS

NEAREST, SPARSE, IN_COST_SPACE = range(3)  # kinds of growth: RRT, SST, AO-RRT


class Growth(NamedTuple):
    """How a tree grows, for compiled kernels; the radii are of sparse trees."""

    goal_bias: float  # probability of sampling the goal
    control_samples: int  # candidate inputs, of which the one leading nearest is applied
    min_steps: int  # of an input
    max_steps: int
    kind: int = NEAREST
    selection_radius: float = 0.0  # about a sample, within which the cheapest node is selected
    improving_radius: float = 0.0  # the same, where a motion is known
    pruning_radius: float = 0.0  # about a witness, within which only one node is extended
    cost_weight: float = 0.0  # distance of the cost bound, in diameters of the state space


class Worker(NamedTuple):
    """What grows a tree, for compiled kernels; several workers share its nodes and indices."""

    search: SearchState
    tree: Tree
    growth: Growth
    witnesses: Witnesses  # of sparse trees
    costs: CostIndex  # of trees in state-cost space
    ends: Ends  # of a worker whose tree others read
    most: Integers  # (1,) cost bound: steps that a solution must stay below
    best: Array  # (2,) the node nearest to the goal and its normalised goal error


@kernel
def begin(worker):  # type: ignore[no-untyped-def]
    """Clear the tree of a ``Worker`` to its start."""
    search, tree, witnesses, costs = worker.search, worker.tree, worker.witnesses, worker.costs
    begin_tree(search, tree)
    metric_coordinates(search.problem, search.problem.start, tree.point)
    if worker.growth.kind == SPARSE:
        clear(witnesses.neighbours)
        represent(witnesses, NOBODY, 0, 0, tree.point)
    elif is_in_cost_space(worker):
        clear(costs.neighbours)
        locate(costs, tree.point, 0.0)
        add(costs.neighbours, costs.point)
    else:
        clear(tree.neighbours)
        add(tree.neighbours, tree.point)
    worker.best[0], worker.best[1] = 0.0, math.inf


@kernel
def is_in_cost_space(worker):  # type: ignore[no-untyped-def]
    """Say whether the tree of a ``Worker`` grows below a cost bound, in state and cost."""
    return worker.growth.kind == IN_COST_SPACE and worker.most[0] < UNBOUNDED_STEPS


@kernel
def grow(worker, iterations, apart):  # type: ignore[no-untyped-def]
    """Grow a tree for some iterations.

    Args:
        worker: ``Worker``; its tree and indices are written.
        iterations: Maximum number of iterations.
        apart: Whether others read the tree: then ends are kept, and not added.

    Returns:
        GROWING, REACHED or FULL, and the number of iterations made.
    """
    search, tree, growth, done = worker.search, worker.tree, worker.growth, 0
    while True:
        lane = lane_to_serve(search, tree, growth.min_steps, worker.best[1])
        if has_ended(tree, lane):
            if apart:
                keep_end(tree, lane, worker.ends)
                continue
            if is_full(worker):
                return FULL, done
            status = add_end(worker, *end_extension(tree, lane))
            if status != GROWING:
                return status, done
            continue
        if done >= iterations:
            return GROWING, done
        done += 1
        tree.extensions.draws[lane] += 1
        parent = draw_node(worker)
        if parent != NONE:
            least, longest = growth.min_steps, growth.max_steps
            steps = directed_control(search, tree, parent, least, longest, growth.control_samples)
            if tree.cost_entry < 0:
                steps = min(steps, worker.most[0] - 1 - tree.cost[parent])
            begin_extension(search, tree, lane, parent, steps)


@kernel
def prune(worker):  # type: ignore[no-untyped-def]
    """Prune the sparse tree of a ``Worker``; say whether enough capacity is left to continue."""
    return sweep(worker.tree, worker.witnesses, worker.best, worker.most[0])


@kernel
def is_full(worker):  # type: ignore[no-untyped-def]
    """Say whether the tree of a ``Worker`` has no room for a node; a sparse one is swept first."""
    if worker.tree.size[0] < worker.tree.x.shape[0]:
        return False
    return worker.growth.kind != SPARSE or not prune(worker)


@kernel
def add_end(worker, parent, made, violation, known_clearance):  # type: ignore[no-untyped-def]
    """Add the end of an extension to a tree that has room for it, if it is to be kept.

    Args:
        worker: ``Worker``; state and inputs are in ``now`` and ``held`` of its tree.
        parent, made: The node that was extended, and the number of steps.
        violation, known_clearance: Normalised goal error at the end, and clearance there in [m].

    Returns:
        GROWING or REACHED.
    """
    search, tree, growth, most = worker.search, worker.tree, worker.growth, worker.most[0]
    witnesses, costs, sparse = worker.witnesses, worker.costs, growth.kind == SPARSE
    cost, inside = cost_at(tree, parent, tree.now, made), is_inside(violation)
    late = cost + 1 >= most
    if made < growth.min_steps or (late and not (sparse or inside)):
        tree.failures[parent] += 1
        return GROWING
    metric_coordinates(search.problem, tree.now, tree.point)
    witness = witness_at(witnesses, tree.point, growth.pruning_radius) if sparse else NOBODY
    cheaper = not late and (witness == NOBODY or cost < witnesses.cost[witness])
    if sparse and not (cheaper or inside or violation < worker.best[1]):
        return GROWING
    node = insert_node(tree, tree.now, tree.held, parent, made, known_clearance)
    if sparse:
        if cheaper:
            represent(witnesses, witness, node, cost, tree.point)
    elif is_in_cost_space(worker):
        locate(costs, tree.point, cost * cost_per_step(worker))
        add(costs.neighbours, costs.point)
    else:
        add(tree.neighbours, tree.point)
    return note_nearest(worker.best, node, violation)


@kernel
def draw_node(worker):  # type: ignore[no-untyped-def]
    """Return the node of a ``Worker`` to extend, chosen by a sample, or NONE where it often failed.

    It is the less likely to be extended, the more often that has failed. Where no motion, not even
    the start, is below the bound, a sparse tree has no witness, and nothing is extended.
    """
    search, tree, growth, most = worker.search, worker.tree, worker.growth, worker.most[0]
    sample_state(search.problem, search.random, growth.goal_bias, tree.target)
    metric_coordinates(search.problem, tree.target, tree.aim)
    if growth.kind == SPARSE:
        if worker.witnesses.neighbours.counts[0] == 0:
            return np.int64(NONE)
        known = most < UNBOUNDED_STEPS
        radius = growth.improving_radius if known else growth.selection_radius
        parent = np.int64(select(worker.witnesses, tree.aim, radius))
    elif is_in_cost_space(worker):
        locate(worker.costs, tree.aim, uniform(search.random) * most * cost_per_step(worker))
        parent, _ = nearest(worker.costs.neighbours, worker.costs.point, 0, math.inf)
    else:
        parent, _ = nearest(tree.neighbours, tree.aim, 0, math.inf)
    return parent if uniform(search.random) * (1.0 + tree.failures[parent]) <= 1.0 else NONE


@kernel
def cost_per_step(worker):  # type: ignore[no-untyped-def]
    """Return the distance of a step in state-cost space."""
    return worker.growth.cost_weight * worker.costs.extent / worker.most[0]


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
