"""SST kernel: a sparse tree that grows from its cheapest nodes.

Source: Li, Littlefield, Bekris, Asymptotically optimal sampling-based kinodynamic planning, IJRR
35(5), 2016.
"""

from __future__ import annotations

from kinolab.numerics.jit import kernel
from kinolab.numerics.rng import uniform
from kinolab.search.tree.problem_arrays import metric_coordinates, sample_state
from kinolab.search.tree.rrt_kernel import extend, propagate
from kinolab.search.tree.tree import FULL, GROWING, REACHED, TOLERANCE_FRACTION, insert_node
from kinolab.search.tree.witnesses import NOBODY, represent, select, sweep, witness_at


@kernel
def grow_sparsely(  # type: ignore[no-untyped-def]
    search, tree, witnesses, best, iterations, most,
    selection_radius, pruning_radius, goal_bias, control_samples, min_steps, max_steps,
):  # fmt: skip
    """Grow a tree for some iterations.

    Args:
        search: The problem and scratch memory.
        tree: The tree, without its own kd-forest; written.
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
    arrays, random = search.problem, search.random
    for done in range(iterations):
        if tree.size[0] >= tree.x.shape[0] and not sweep(tree, witnesses, best, most):
            return FULL, done
        sample_state(arrays, random, goal_bias, tree.target)
        metric_coordinates(arrays, tree.target, tree.aim)
        parent = select(witnesses, tree.aim, selection_radius)
        if uniform(random) * (1.0 + tree.failures[parent]) > 1.0:
            continue
        longest = propagate(search, tree, parent, min_steps, max_steps, control_samples)
        longest = min(longest, most - 1 - tree.cost[parent])
        made, violation, known_clearance = extend(search, tree, parent, min_steps, longest, best[1])
        if made < min_steps:
            tree.failures[parent] += 1
            continue
        inside, cost = violation <= TOLERANCE_FRACTION, tree.cost[parent] + made
        metric_coordinates(arrays, tree.now, tree.point)
        witness = witness_at(witnesses, tree.point, pruning_radius)
        cheaper = cost + 1 < most and (witness == NOBODY or cost < witnesses.cost[witness])
        if not (cheaper or inside or violation < best[1]):
            continue
        node = insert_node(tree, tree.now, tree.held, parent, made, known_clearance)
        if cheaper:
            represent(witnesses, witness, node, cost, tree.point)
        if violation < best[1]:
            best[0], best[1] = node, violation
        if inside:
            return REACHED, done + 1
    return GROWING, iterations
