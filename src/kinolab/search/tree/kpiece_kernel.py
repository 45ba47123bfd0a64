"""A tree that grows where cells are important, compiled as a whole.

Motions that lead nowhere new are mostly forgotten, so that the tree stays small; one that goes
through a new cell leaves a node there.

Source: Sucan, Kavraki, Kinodynamic motion planning by interior-exterior cell exploration, WAFR
2008.
"""

from __future__ import annotations

import math

import numpy as np

from kinolab.numerics.jit import kernel
from kinolab.numerics.rng import below, uniform
from kinolab.search.tree.cost_to_go import cell_at
from kinolab.search.tree.kpiece_grid import choose, clear_cells, holds, key_of, put, rate
from kinolab.search.tree.limits import keeps_limits
from kinolab.search.tree.problem_arrays import goal_violation, sample_control
from kinolab.search.tree.tree import (
    FULL,
    GROWING,
    REACHED,
    TOLERANCE_FRACTION,
    begin_without_neighbours,
    insert_node,
    step_is_free,
)
from kinolab.simulation.collision_context import speed_bound
from kinolab.simulation.machine import advance

KEEP_PROBABILITY = 0.05  # probability that a motion is kept that leads nowhere new


@kernel
def explore(  # type: ignore[no-untyped-def]
    search, tree, cells, grid, best, iterations, min_steps, max_steps, cost_to_go_exponent,
    control_samples,
):  # fmt: skip
    """Grow a tree by some iterations.

    Args:
        search: The problem, and scratch memory.
        tree: Grows.
        cells, grid: Over the problem's states.
        best: The node nearest to the goal, and its excess (2,); written.
        iterations: How many at most.
        min_steps, max_steps: For how many steps an input is held.
        cost_to_go_exponent: Power of the way to the goal by which cells count less.
        control_samples: Inputs of which that one is held which leads furthest to the goal.

    Returns:
        How it ended, and how many iterations were made.
    """
    now, after, u, random = tree.now, tree.after, tree.held, search.random
    for done in range(iterations):
        if tree.size[0] >= tree.x.shape[0]:
            return FULL, done
        cell, parent = choose(cells, random)
        steps = propagate(search, tree, grid, parent, min_steps, max_steps, control_samples)
        for i in range(now.shape[0]):
            now[i] = tree.x[parent, i]
        made, known_clearance, new = 0, np.float64(tree.clearance[parent]), False
        speed = speed_bound(search.machine, now, u, search.scratch)
        for step in range(steps):
            clearance, speed = step_is_free(search, tree, now, u, after, known_clearance, speed)
            if clearance < 0.0:
                break
            made, known_clearance = made + 1, clearance
            for i in range(now.shape[0]):
                now[i] = after[i]
            if made < min_steps or tree.size[0] >= tree.x.shape[0]:
                continue
            violation = goal_violation(search, now, math.inf)
            far = grid.steps[cell_at(grid, now)]
            key = key_of(cells, search.problem.goal, now, far)
            first = holds(cells, key) == 0
            if (
                first
                or violation <= TOLERANCE_FRACTION
                or (step == steps - 1 and uniform(random) < KEEP_PROBABILITY)
            ):
                parent = insert_node(tree, now, u, parent, made, known_clearance)
                made, new = 0, new or first
                put(cells, key, parent, score(tree, far, cost_to_go_exponent))
                if violation < best[1]:
                    best[0], best[1] = parent, violation
                if violation <= TOLERANCE_FRACTION:
                    return REACHED, done + 1
        rate(cells, cell, new)
    return GROWING, iterations


@kernel
def start_in_a_cell(search, tree, cells):  # type: ignore[no-untyped-def]
    """Leave nothing in the tree and its cells but the start."""
    arrays = search.problem
    clear_cells(cells)
    node = begin_without_neighbours(search, tree)
    put(cells, key_of(cells, arrays.goal, arrays.start, math.inf), node, 1.0)


@kernel
def score(tree, far, cost_to_go_exponent):  # type: ignore[no-untyped-def]
    """Return the score of a new cell: later ones count more, and those nearer to the goal."""
    return math.log(1.0 + tree.size[0]) / (1.0 + far) ** cost_to_go_exponent


@kernel
def propagate(search, tree, grid, parent, min_steps, max_steps, control_samples):  # type: ignore[no-untyped-def]
    """Write the input to hold from a node to ``tree.held``; return for how many steps.

    Args:
        search, tree, grid: ``SearchState``, ``Tree`` and ``CostToGoGrid``.
        parent: The node.
        min_steps, max_steps: For how many steps an input is held.
        control_samples: Inputs of which that one is held which leads furthest to the goal.
    """
    least, longest, random = math.inf, 0, search.random
    for k in range(control_samples):
        sample_control(search.problem, random, tree.drawn)
        steps, far = min_steps + below(random, max_steps - min_steps + 1), 0.0
        if control_samples > 1:
            far, steps = cost_to_go_after(search, tree, grid, parent, steps)
        if k == 0 or far < least:
            least, longest = far, max(steps, min_steps)
            for i in range(tree.held.shape[0]):
                tree.held[i] = tree.drawn[i]
    return longest


@kernel
def cost_to_go_after(search, tree, grid, parent, steps):  # type: ignore[no-untyped-def]
    """Return how far from the goal an input leads at best, obstacles apart, and after how long.

    Args:
        search, tree, grid: ``SearchState``, ``Tree`` and ``CostToGoGrid``.
        parent: The node.
        steps: For how many the input, ``tree.drawn``, is held.
    """
    now, after, u = tree.now, tree.after, tree.drawn
    machine, arrays = search.machine, search.problem
    for i in range(now.shape[0]):
        now[i] = tree.x[parent, i]
    least, at = math.inf, 1
    for step in range(steps):
        failed = advance(machine, now, u, arrays.step, after)
        if failed != 0 or not keeps_limits(arrays.limits, after):
            break
        for i in range(now.shape[0]):
            now[i] = after[i]
        far = grid.steps[cell_at(grid, now)]
        if far <= least:
            least, at = far, step + 1
    return least, at
