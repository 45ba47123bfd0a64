"""SST kernel: a sparse tree that grows from its cheapest nodes.

Source: Li, Littlefield, Bekris, Asymptotically optimal sampling-based kinodynamic planning, IJRR
35(5), 2016.
"""

from __future__ import annotations

import numpy as np

from kinolab.numerics.jit import kernel
from kinolab.search.tree.extensions import (
    begin_extension,
    end_extension,
    has_ended,
    lane_to_serve,
)
from kinolab.search.tree.problem_arrays import is_inside, metric_coordinates, sample_state
from kinolab.search.tree.sampled.directed_control import directed_control, is_tried
from kinolab.search.tree.sampled.witnesses import NOBODY, represent, select, sweep, witness_at
from kinolab.search.tree.tree import (
    FULL,
    GROWING,
    NONE,
    insert_node,
    note_nearest,
)


@kernel
def grow_sparsely(  # type: ignore[no-untyped-def]
    search, tree, witnesses, best, iterations, most,
    selection_radius, pruning_radius, goal_bias, control_samples, min_steps, max_steps,
):  # fmt: skip
    """Grow a tree for some iterations.

    Args:
        search: The problem and scratch memory.
        tree: The tree, without an index of its own; written.
        witnesses: Of the tree; written.
        best: The node nearest to the goal and its normalised goal error (2,); written.
        iterations: Maximum number of iterations.
        most: Cost bound: steps that a solution must stay below.
        selection_radius: Radius about a sample within which the cheapest node is selected.
        pruning_radius: Radius about a witness within which only one node is extended.
        goal_bias: Probability of sampling the goal.
        control_samples: Number of candidate inputs, of which the one leading nearest is applied.
        min_steps, max_steps: Range of the control duration in steps.

    Returns:
        GROWING, REACHED or FULL, and the number of iterations made.
    """
    done = 0
    while True:
        lane = lane_to_serve(search, tree, min_steps, best[1])
        if has_ended(tree, lane):
            status = settle_sparsely(
                search, tree, witnesses, lane, best, min_steps, most, pruning_radius
            )
            if status != GROWING:
                return status, done
            continue
        if done >= iterations:
            return GROWING, done
        done += 1
        tree.extensions.draws[lane] += 1
        parent = draw_sparsely(search, tree, witnesses, goal_bias, selection_radius)
        if parent != NONE:
            steps = directed_control(search, tree, parent, min_steps, max_steps, control_samples)
            steps = min(steps, most - 1 - tree.cost[parent])
            begin_extension(search, tree, lane, parent, steps)


@kernel
def settle_sparsely(  # type: ignore[no-untyped-def]
    search, tree, witnesses, lane, best, min_steps, most, pruning_radius,
):  # fmt: skip
    """Add the end of an extension to the tree if its witness has no cheaper node.

    Args:
        search, tree, witnesses: ``SearchState``, ``Tree`` and ``Witnesses``.
        lane: Where it has ended.
        best: The node nearest to the goal and its normalised goal error (2,); written.
        most, pruning_radius: Bound and radius, as ``grow_sparsely`` takes them.
        min_steps: Fewest steps that are kept.

    Returns:
        GROWING, REACHED or FULL.
    """
    if tree.size[0] >= tree.x.shape[0] and not sweep(tree, witnesses, best, most):
        return FULL
    return add_end_sparsely(
        search, tree, witnesses, best, min_steps, most, pruning_radius, *end_extension(tree, lane)
    )


@kernel
def add_end_sparsely(  # type: ignore[no-untyped-def]
    search, tree, witnesses, best, min_steps, most, pruning_radius,
    parent, made, violation, known_clearance,
):  # fmt: skip
    """Add the end of an extension to a tree that has room, if its witness has no cheaper node.

    Args:
        search, tree: ``SearchState`` and ``Tree``; state and inputs are in ``now`` and ``held``.
        witnesses: Of the tree; written.
        best: The node nearest to the goal and its normalised goal error (2,); written.
        min_steps, most, pruning_radius: As ``settle_sparsely`` takes them.
        parent, made: The node that was extended, and the number of steps.
        violation, known_clearance: Normalised goal error at the end, and clearance there in [m].

    Returns:
        GROWING or REACHED.
    """
    if made < min_steps:
        tree.failures[parent] += 1
        return GROWING
    cost = tree.cost[parent] + made
    metric_coordinates(search.problem, tree.now, tree.point)
    witness = witness_at(witnesses, tree.point, pruning_radius)
    cheaper = cost + 1 < most and (witness == NOBODY or cost < witnesses.cost[witness])
    if not (cheaper or is_inside(violation) or violation < best[1]):
        return GROWING
    node = insert_node(tree, tree.now, tree.held, parent, made, known_clearance)
    if cheaper:
        represent(witnesses, witness, node, cost, tree.point)
    return note_nearest(best, node, violation)


@kernel
def draw_sparsely(search, tree, witnesses, goal_bias, selection_radius):  # type: ignore[no-untyped-def]
    """Return the node to extend, the cheapest near a sample, or NONE where it has often failed.

    Args:
        search, tree, witnesses: ``SearchState``, ``Tree`` and ``Witnesses``.
        goal_bias: Probability of sampling the goal.
        selection_radius: As ``grow_sparsely`` takes it.
    """
    sample_state(search.problem, search.random, goal_bias, tree.target)
    metric_coordinates(search.problem, tree.target, tree.aim)
    parent = np.int64(select(witnesses, tree.aim, selection_radius))
    return parent if is_tried(search, tree, parent) else NONE
