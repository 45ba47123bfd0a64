"""KPIECE kernel: a tree that grows from important cells.

Motions that reach no new cell are mostly discarded, so the tree stays small; one that passes
through a new cell leaves a node there.

Source: Sucan, Kavraki, Kinodynamic motion planning by interior-exterior cell exploration, WAFR
2008.
"""

from __future__ import annotations

import math

import numpy as np

from kinolab.dynamics.codegen.integrators import LANES
from kinolab.numerics.jit import kernel
from kinolab.numerics.rng import uniform
from kinolab.search.tree.flat_arrays import copy
from kinolab.search.tree.kpiece.cost_to_go import cell_at, coasting_cost
from kinolab.search.tree.kpiece.kpiece_grid import choose, clear_cells, holds, key_of, put, rate
from kinolab.search.tree.lanes import (
    NOWHERE,
    advance_lanes,
    draw_control,
    draw_lanes,
    hold_best_lane,
)
from kinolab.search.tree.problem_arrays import goal_violation, is_inside
from kinolab.search.tree.tree import (
    ALL_STEPS,
    FULL,
    GROWING,
    REACHED,
    begin_tree,
    cost_at,
    insert_node,
    made_step_is_free,
    note_nearest,
    step_is_free,
)
from kinolab.simulation.collision_context import speed_bound
from kinolab.simulation.limits import keeps_limits
from kinolab.simulation.machine import call_under, derivative_in_lanes


@kernel
def explore(  # type: ignore[no-untyped-def]
    search, tree, cells, grid, best, iterations, most, pace, min_steps, max_steps,
    cost_to_go_exponent, control_samples,
):  # fmt: skip
    """Grow a tree for some iterations.

    Args:
        search: The problem and scratch memory.
        tree: The tree; written.
        cells, grid: ``KpieceGrid`` and ``CostToGoGrid``.
        best: The node nearest to the goal and its normalised goal error (2,); written.
        iterations: Maximum number of iterations.
        most: Cost bound: steps that a solution must stay below.
        pace: Fraction of that bound's pace along the cost to go that every node must keep; 0 for
            the bound alone.
        min_steps, max_steps: Range of the control duration in steps.
        cost_to_go_exponent: Power of the cost to go by which a cell's score falls.
        control_samples: Number of candidate inputs, of which the one of least cost to go is
            applied.

    Returns:
        GROWING, REACHED or FULL, and the number of iterations made.
    """
    now, after, u, random = tree.now, tree.after, tree.held, search.random
    before, horizon = tree.target, mean_steps(min_steps, max_steps)
    whole = grid.steps[cell_at(grid, search.problem.start)]
    # cells from the start to the goal, where the cost to go says how far a node has come
    steps_per_cell = pace * most / whole if 3.0 <= whole < math.inf else 0.0
    for done in range(iterations):
        if tree.size[0] >= tree.x.shape[0]:
            return FULL, done
        cell, parent = choose(cells, random)
        steps, known = directed_control(
            search, tree, grid, parent, min_steps, max_steps, control_samples
        )
        copy(tree.x[parent], now)
        made, known_clearance, new = 0, np.float64(tree.clearance[parent]), False
        speed = speed_bound(search.machine, now, u, search.scratch)
        for step in range(steps):
            if step < known:
                read_step(search, tree, step)
                clearance, speed = made_step_is_free(
                    search, tree, now, u, after, known_clearance, speed
                )
            else:
                clearance, speed = step_is_free(search, tree, now, u, after, known_clearance, speed)
            if clearance < 0.0:
                break
            made, known_clearance = made + 1, clearance
            copy(now, before)
            copy(after, now)
            if made < min_steps or tree.size[0] >= tree.x.shape[0]:
                continue
            far = grid.steps[cell_at(grid, now)]
            cost = np.float64(cost_at(tree, parent, now, made))
            if cost >= most or (steps_per_cell > 0.0 and cost + steps_per_cell * far >= most):
                break
            violation = goal_violation(search, now, math.inf)
            key = key_of(cells, search.problem.goal, now, far)
            first = holds(cells, key) == 0
            if (
                first
                or is_inside(violation)
                # probability of keeping a motion that reaches no new cell
                or (step == steps - 1 and uniform(random) < 0.05)
            ):
                parent = insert_node(tree, now, u, parent, made, known_clearance)
                made, new = 0, new or first
                leads = coasting_cost(grid, before, now, horizon, search.scratch.x)
                put(cells, key, parent, score(tree, leads, cost_to_go_exponent))
                if note_nearest(best, parent, violation) == REACHED:
                    return REACHED, done + 1
        rate(cells, cell, new)
    return GROWING, iterations


@kernel
def mean_steps(min_steps, max_steps):  # type: ignore[no-untyped-def]
    """Return for how many steps an input is held on average: motions are taken to go on as long."""
    return 0.5 * (min_steps + max_steps)


@kernel
def start_in_a_cell(search, tree, cells):  # type: ignore[no-untyped-def]
    """Clear the tree and its cells to the start."""
    arrays = search.problem
    clear_cells(cells)
    node = begin_tree(search, tree)
    put(cells, key_of(cells, arrays.goal, arrays.start, math.inf), node, 1.0)


@kernel
def score(tree, leads, cost_to_go_exponent):  # type: ignore[no-untyped-def]
    """Return the score of a new cell, higher for later cells and for those that lead to the goal.

    Args:
        tree: ``Tree``.
        leads: Cost to go of where the motion into the cell leads, in cells.
        cost_to_go_exponent: As ``explore`` takes it.
    """
    return math.log(1.0 + tree.size[0]) / (1.0 + leads) ** cost_to_go_exponent


@kernel
def read_step(search, tree, step):  # type: ignore[no-untyped-def]
    """Read a step of the input that is held, which is known: where it leads, and its slopes.

    Args:
        search, tree: ``SearchState`` and ``Tree``; ``tree.now`` is where the step begins.
        step: Its number.
    """
    lanes, slope = tree.lanes, search.problem.limits.slope
    tree.rejections[ALL_STEPS] += 1
    copy(lanes.chosen[step], tree.after)
    lane = step % LANES
    if lane == 0:
        slopes_ahead(search, tree, step)
    copy(slope[1], slope[0])
    copy(lanes.slope[:, lane], slope[1])


@kernel
def slopes_ahead(search, tree, step):  # type: ignore[no-untyped-def]
    """Compute the derivatives of the state after a known step and those that follow, in lanes.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        step: Number of the first; before the very first ``limits.slope[1]`` is set, too.
    """
    lanes, last = tree.lanes, tree.lanes.chosen.shape[0] - 1
    for lane in range(LANES):
        copy(tree.held, lanes.held[:, lane])
        copy(lanes.chosen[min(step + lane, last)], lanes.now[:, lane])
    derivative_in_lanes(search.machine, lanes.now, lanes.held, lanes.slope)
    if step == 0:
        slope, p = search.problem.limits.slope, search.machine.p.ctypes.data
        at, under = tree.now.ctypes.data, tree.held.ctypes.data
        call_under(search.machine.f, at, under, p, slope[1].ctypes.data)


@kernel
def directed_control(search, tree, grid, parent, min_steps, max_steps, control_samples):  # type: ignore[no-untyped-def]
    """Write the input to apply from a node to ``tree.held``.

    Args:
        search, tree, grid: ``SearchState``, ``Tree`` and ``CostToGoGrid``.
        parent: The node.
        min_steps, max_steps: Range of the control duration in steps.
        control_samples: Number of candidate inputs, of which the one of least cost to go is
            applied.

    Returns:
        Its number of steps, and of those to which the states are in ``tree.lanes.chosen``.
    """
    if control_samples == 1:
        return draw_control(search, tree.held, min_steps, max_steps), 0
    least, longest, horizon = math.inf, np.int64(0), mean_steps(min_steps, max_steps)
    for first in range(0, control_samples, LANES):
        inputs = min(LANES, control_samples - first)
        most = draw_lanes(search, tree, parent, inputs, min_steps, max_steps)
        cost_to_go_in_lanes(search, tree, grid, inputs, most, horizon)
        least, longest, held = hold_best_lane(tree, inputs, least, longest)
        if held != NOWHERE:
            for step in range(longest):
                copy(tree.lanes.track[step, :, held], tree.lanes.chosen[step])
    # Nothing is known of an input whose first step fails, nor without code for slopes in lanes.
    known = longest if least < math.inf and search.machine.step_in_lanes != 0 else 0
    return max(longest, min_steps), known


@kernel
def cost_to_go_in_lanes(search, tree, grid, inputs, most, horizon):  # type: ignore[no-untyped-def]
    """Set the cost of the input of every lane, and the step with the least cost to go along it.

    The states along them are left in ``tree.lanes.track``.

    Args:
        search, tree, grid: ``SearchState``, ``Tree`` and ``CostToGoGrid``.
        inputs: Number of lanes in use.
        most: Steps of the longest one.
        horizon: Steps for which a motion is taken to go straight on.
    """
    lanes, arrays, ahead = tree.lanes, search.problem, search.scratch.x
    now, cost, best = lanes.now, lanes.least, lanes.best
    least = lanes.nearest
    for lane in range(inputs):
        cost[lane], least[lane], best[lane] = math.inf, math.inf, 1
    for step in range(most):
        after = lanes.track[step]
        failed = advance_lanes(search, tree, step, now, after)
        running = False
        for lane in range(inputs):
            if step >= lanes.steps[lane]:
                continue
            x = after[:, lane]
            if (failed >> lane) & 1 or not keeps_limits(arrays.limits, x):
                lanes.steps[lane] = 0
                continue
            running = True
            far = grid.steps[cell_at(grid, x)]
            if far <= least[lane]:
                least[lane], best[lane] = far, step + 1
                leads = coasting_cost(grid, now[:, lane], x, horizon, ahead)
                # weight of the cost to go where a motion leads, beside that of where it ends
                cost[lane] = far + 2.0 * leads
        if not running:
            break
        now = after
