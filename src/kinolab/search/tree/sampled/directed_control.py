"""The input to apply from a node: of several samples the one that leads nearest to a target."""

from __future__ import annotations

import math

import numpy as np

from kinolab.dynamics.codegen.integrators import LANES
from kinolab.numerics.jit import kernel
from kinolab.search.tree.lanes import advance_lanes, draw_control, draw_lanes, hold_best_lane
from kinolab.search.tree.problem_arrays import metric_coordinates


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
    if control_samples == 1:
        return draw_control(search, tree.held, min_steps, max_steps)
    least, longest = math.inf, np.int64(0)
    for first in range(0, control_samples, LANES):
        inputs = min(LANES, control_samples - first)
        most = draw_lanes(search, tree, parent, inputs, min_steps, max_steps)
        extend_toward(search, tree, inputs, most)
        least, longest, _ = hold_best_lane(tree, inputs, least, longest)
    return longest


@kernel
def extend_toward(search, tree, inputs, most):  # type: ignore[no-untyped-def]
    """Set the squared distance from ``tree.aim`` of where the input of every lane leads at its end.

    Obstacles are ignored.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        inputs: Number of lanes in use.
        most: Steps of the longest one.
    """
    lanes = tree.lanes
    now, after = lanes.now, lanes.after
    for step in range(most):
        failed = advance_lanes(search, tree, step, now, after)
        now, after = after, now
        for lane in range(inputs):
            lost, steps = (failed >> lane) & 1, lanes.steps[lane]
            if step + 1 == steps or (lost and step < steps):
                gap = gap_to(search, tree, now[:, lane], tree.aim)
                lanes.least[lane] = math.inf if lost else gap
                lanes.best[lane], lanes.steps[lane] = steps, 0


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
