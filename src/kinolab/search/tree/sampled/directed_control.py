"""RRT kernel: a rapidly-exploring random tree in one compiled loop.

Source: LaValle, Kuffner, Randomized kinodynamic planning, IJRR 20(5), 2001.
"""

from __future__ import annotations

import math

import numpy as np

from kinolab.dynamics.codegen.integrators import LANES
from kinolab.numerics.jit import kernel
from kinolab.numerics.neighbours.queries import nearest
from kinolab.numerics.rng import below, uniform
from kinolab.search.tree.extensions import (
    begin_extension,
    end_extension,
    has_ended,
    lane_to_serve,
)
from kinolab.search.tree.lanes import draw_lanes, hold_best_lane
from kinolab.search.tree.problem_arrays import (
    metric_coordinates,
    sample_control,
    sample_state,
)
from kinolab.search.tree.tree import (
    FULL,
    GROWING,
    NONE,
    insert,
    note_nearest,
)
from kinolab.simulation.machine import advance, advance_in_lanes


@kernel
def grow(  # type: ignore[no-untyped-def]
    search, tree, best, iterations, goal_bias, control_samples, min_steps, max_steps,
):  # fmt: skip
    """Grow a tree for some iterations.

    Args:
        search: The problem and scratch memory.
        tree: The tree; written.
        best: The node nearest to the goal and its normalised goal error (2,); written.
        iterations: Maximum number of iterations.
        goal_bias: Probability of sampling the goal.
        control_samples: Number of candidate inputs.
        min_steps, max_steps: Range of the control duration in steps.

    Returns:
        GROWING, REACHED or FULL, and the number of iterations made.
    """
    done = 0
    while True:
        lane = lane_to_serve(search, tree, min_steps, best[1])
        if has_ended(tree, lane):
            status = settle(search, tree, lane, best, min_steps)
            if status != GROWING:
                return status, done
            continue
        if done >= iterations:
            return GROWING, done
        done += 1
        tree.extensions.draws[lane] += 1
        parent = draw_node(search, tree, goal_bias)
        if parent != NONE:
            steps = directed_control(search, tree, parent, min_steps, max_steps, control_samples)
            begin_extension(search, tree, lane, parent, steps)


@kernel
def settle(search, tree, lane, best, min_steps):  # type: ignore[no-untyped-def]
    """Add the end of an extension to the tree.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        lane: Where it has ended.
        best: The node nearest to the goal and its normalised goal error (2,); written.
        min_steps: Fewest steps that are kept.

    Returns:
        GROWING, REACHED or FULL.
    """
    if tree.size[0] >= tree.x.shape[0]:
        return FULL
    return add_end(search, tree, best, min_steps, *end_extension(tree, lane))


@kernel
def add_end(search, tree, best, min_steps, parent, made, violation, known_clearance):  # type: ignore[no-untyped-def]
    """Add the end of an extension to a tree that has room for it.

    Args:
        search, tree: ``SearchState`` and ``Tree``; state and inputs are in ``now`` and ``held``.
        best: The node nearest to the goal and its normalised goal error (2,); written.
        min_steps: Fewest steps that are kept.
        parent, made: The node that was extended, and the number of steps.
        violation, known_clearance: Normalised goal error at the end, and clearance there in [m].

    Returns:
        GROWING or REACHED.
    """
    if made < min_steps:
        tree.failures[parent] += 1
        return GROWING
    node = insert(search, tree, tree.now, tree.held, parent, made, known_clearance)
    return note_nearest(best, node, violation)


@kernel
def draw_node(search, tree, goal_bias):  # type: ignore[no-untyped-def]
    """Return the node to extend, nearest to a sample, or NONE where it has often failed."""
    sample_state(search.problem, search.random, goal_bias, tree.target)
    metric_coordinates(search.problem, tree.target, tree.aim)
    parent, _ = nearest(tree.neighbours, tree.aim, 0, math.inf)
    return parent if is_tried(search, tree, parent) else NONE


@kernel
def is_tried(search, tree, node):  # type: ignore[no-untyped-def]
    """Draw whether a node is extended: the less likely, the more often that has failed."""
    return uniform(search.random) * (1.0 + tree.failures[node]) <= 1.0


@kernel
def directed_control(search, tree, parent, min_steps, max_steps, control_samples):  # type: ignore[no-untyped-def]
    """Write the input to apply from a node to ``tree.held``; return its number of steps.

    Of several samples it is the one that leads nearest, as OMPL's directed control samplers do it.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        parent: The node.
        min_steps, max_steps: Range of the control duration in steps.
        control_samples: Number of candidate inputs, of which the one leading nearest is applied.
    """
    if control_samples > 1 and search.machine.step_in_lanes != 0:
        return directed_control_in_lanes(
            search, tree, parent, min_steps, max_steps, control_samples
        )
    least, longest, drawn, random = math.inf, 0, tree.drawn, search.random
    for k in range(control_samples):
        sample_control(search.problem, random, drawn)
        steps, gap = min_steps + below(random, max_steps - min_steps + 1), 0.0
        if control_samples > 1:
            gap = extend_toward(search, tree, parent, drawn, steps, tree.aim)
        if k == 0 or gap < least:
            least, longest = gap, steps
            for i in range(drawn.shape[0]):
                tree.held[i] = drawn[i]
    return longest


@kernel
def extend_toward(search, tree, parent, u, steps, point):  # type: ignore[no-untyped-def]
    """Return the squared distance from the end of an input to a target, ignoring obstacles.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        parent: The node.
        u: Input, shape (nu,).
        steps: Its duration in steps.
        point: The target in coordinates of the metric, shape (d,).
    """
    now, after, machine, arrays = tree.now, tree.after, search.machine, search.problem
    for i in range(now.shape[0]):
        now[i] = tree.x[parent, i]
    for _ in range(steps):
        if advance(machine, now, u, arrays.step, after) != 0:
            return math.inf
        for i in range(now.shape[0]):
            now[i] = after[i]
    return gap_to(search, tree, now, point)


@kernel
def gap_to(search, tree, x, point):  # type: ignore[no-untyped-def]
    """Return the squared distance of a state (nx,) from a target in coordinates (d,)."""
    metric_coordinates(search.problem, x, tree.point)
    total, period = 0.0, tree.neighbours.period
    for i in range(period.shape[0]):
        gap = abs(tree.point[i] - point[i])
        gap = min(gap, period[i] - gap)
        total += gap * gap
    return total


@kernel
def directed_control_in_lanes(search, tree, parent, min_steps, max_steps, control_samples):  # type: ignore[no-untyped-def]
    """Do what ``directed_control`` does, several inputs at once.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        parent, min_steps, max_steps, control_samples: As ``directed_control`` takes them.
    """
    least, longest = math.inf, np.int64(0)
    for first in range(0, control_samples, LANES):
        inputs = min(LANES, control_samples - first)
        most = draw_lanes(search, tree, parent, inputs, min_steps, max_steps)
        extend_toward_in_lanes(search, tree, inputs, most)
        least, longest, _ = hold_best_lane(tree, inputs, least, longest)
    return longest


@kernel
def extend_toward_in_lanes(search, tree, inputs, most):  # type: ignore[no-untyped-def]
    """Set the squared distance from ``tree.aim`` of where the input of every lane leads at its end.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        inputs: Number of lanes in use.
        most: Steps of the longest one.
    """
    lanes, failures = tree.lanes, 0
    now, after = lanes.now, lanes.after
    for step in range(most):
        failed = advance_in_lanes(search.machine, now, lanes.held, search.problem.step, after)
        failures |= failed
        now, after = after, now
        for lane in range(inputs):
            if step + 1 == lanes.steps[lane]:
                gap = gap_to(search, tree, now[:, lane], tree.aim)
                lanes.least[lane] = math.inf if (failures >> lane) & 1 else gap
                lanes.best[lane] = lanes.steps[lane]
