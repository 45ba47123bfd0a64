"""Extensions of a tree, several at once: each lane follows an input from a node of its own.

A lane whose extension has ended is idle until the next one begins there; the others go on. What is
under way stays so between two slices of time.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from kinolab.dynamics.codegen.integrators import LANES
from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.problem.goal import SEARCHED_FRACTION
from kinolab.search.tree.flat_arrays import copy
from kinolab.search.tree.problem_arrays import goal_violation, is_inside
from kinolab.search.tree.tree import (
    ALL_STEPS,
    NONE,
    made_step_is_free,
)
from kinolab.simulation.collision_context import speed_bound
from kinolab.simulation.limits import slopes_of_step
from kinolab.simulation.machine import advance, advance_in_lanes, derivative_in_lanes
from kinolab.simulation.propagator import EQUATIONS


class Ends(NamedTuple):
    """Ends of extensions that are not in the tree yet, for compiled kernels."""

    x: Annotated[Array, "capacity", "nx"]
    u: Annotated[Array, "capacity", "nu"]
    parent: Annotated[Integers, "capacity"]
    made: Annotated[Integers, "capacity"]  # steps
    violation: Annotated[Array, "capacity"]  # normalised goal error
    clearance: Annotated[Array, "capacity"]  # in [m]
    filled: Annotated[Integers, 2]  # number of ends, and of those that were added


@kernel
def begin_extension(search, tree, lane, parent, steps):  # type: ignore[no-untyped-def]
    """Begin to apply ``tree.held`` from a node in an idle lane.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        lane: The lane.
        parent: The node.
        steps: Steps to make at most; there may be none.
    """
    under_way = tree.extensions
    copy(tree.x[parent], tree.now)
    copy(tree.now, under_way.now[:, lane])
    copy(tree.held, under_way.held[:, lane])
    under_way.parent[lane], under_way.steps[lane], under_way.made[lane] = parent, steps, 0
    under_way.ended[lane], under_way.violation[lane] = steps <= 0, math.inf
    under_way.clearance[lane] = tree.clearance[parent]
    under_way.speed[lane] = speed_bound(search.machine, tree.now, tree.held, search.scratch)


@kernel
def end_extension(tree, lane):  # type: ignore[no-untyped-def]
    """Make a lane idle, with its state and inputs in ``tree.now`` and ``tree.held``.

    Returns:
        Parent, steps made, the normalised goal error at their end and the clearance there in [m].
    """
    under_way = tree.extensions
    read_lane(tree, lane)
    parent, under_way.parent[lane] = under_way.parent[lane], NONE
    return parent, under_way.made[lane], under_way.violation[lane], under_way.clearance[lane]


@kernel
def is_idle(tree, lane):  # type: ignore[no-untyped-def]
    """Say whether no extension is in a lane."""
    return tree.extensions.parent[lane] == NONE


@kernel
def has_ended(tree, lane):  # type: ignore[no-untyped-def]
    """Say whether the extension in a lane makes no more steps."""
    return tree.extensions.parent[lane] != NONE and tree.extensions.ended[lane] != 0


@kernel
def read_lane(tree, lane):  # type: ignore[no-untyped-def]
    """Copy state and inputs of a lane to ``tree.now`` and ``tree.held``."""
    under_way = tree.extensions
    copy(under_way.now[:, lane], tree.now)
    copy(under_way.held[:, lane], tree.held)


@kernel
def keep_end(tree, lane, ends):  # type: ignore[no-untyped-def]
    """Make a lane idle whose extension has ended, and keep its end.

    Args:
        tree: Of a worker.
        lane: The lane.
        ends: ``Ends`` of that worker; written.
    """
    parent, made, violation, clearance = end_extension(tree, lane)
    at = ends.filled[0]
    ends.filled[0] += 1
    copy(tree.now, ends.x[at])
    copy(tree.held, ends.u[at])
    ends.parent[at], ends.made[at] = parent, made
    ends.violation[at], ends.clearance[at] = violation, clearance


@kernel
def take_end(tree, ends):  # type: ignore[no-untyped-def]
    """Take the next end that is kept, with its state and inputs in ``tree.now`` and ``tree.held``.

    Args:
        tree: Written.
        ends: Some are left.

    Returns:
        Parent, steps made, the normalised goal error at their end and the clearance there in [m].
    """
    at = ends.filled[1]
    ends.filled[1] += 1
    copy(ends.x[at], tree.now)
    copy(ends.u[at], tree.held)
    return ends.parent[at], ends.made[at], ends.violation[at], ends.clearance[at]


@kernel
def extend_all(search, tree, min_steps, least):  # type: ignore[no-untyped-def]
    """Make the next step of every extension under way.

    One ends where a step is refused, the goal is reached or all its steps are made.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        min_steps: Fewest steps of which the goal error is of interest.
        least: Normalised goal error above which its evaluation may stop early.
    """
    under_way, limits, h = tree.extensions, search.problem.limits, search.problem.step
    machine, in_lanes, failed = search.machine, search.machine.step_in_lanes != 0, np.int64(0)
    now, after = under_way.now, under_way.after
    if in_lanes:
        failed = np.int64(advance_in_lanes(machine, now, under_way.held, h, after))
        derivative_in_lanes(machine, now, under_way.held, under_way.slope)
        derivative_in_lanes(machine, after, under_way.held, under_way.slope_after)
    for lane in range(LANES):
        under_way.draws[lane] = 0
        if is_idle(tree, lane) or has_ended(tree, lane):
            continue
        tree.rejections[ALL_STEPS] += 1
        read_lane(tree, lane)
        if in_lanes:
            copy(after[:, lane], tree.after)
            copy(under_way.slope[:, lane], limits.slope[0])
            copy(under_way.slope_after[:, lane], limits.slope[1])
        elif advance(machine, tree.now, tree.held, h, tree.after) == 0:
            slopes_of_step(machine, limits, tree.now, tree.held, tree.after)
        else:
            failed |= 1 << lane
        if (failed >> lane) & 1:
            tree.rejections[EQUATIONS] += 1
            under_way.ended[lane] = 1
            continue
        clearance, speed = made_step_is_free(
            search, tree, tree.now, tree.held, tree.after, under_way.clearance[lane],
            under_way.speed[lane],
        )  # fmt: skip
        if clearance < 0.0:
            under_way.ended[lane] = 1
            continue
        under_way.clearance[lane], under_way.speed[lane] = clearance, speed
        under_way.made[lane] += 1
        copy(tree.after, now[:, lane])
        if under_way.made[lane] >= min_steps:
            enough = max(least, SEARCHED_FRACTION)
            under_way.violation[lane] = goal_violation(search, tree.after, enough)
        if under_way.made[lane] >= under_way.steps[lane] or is_inside(under_way.violation[lane]):
            under_way.ended[lane] = 1


@kernel
def lane_to_serve(search, tree, min_steps, least):  # type: ignore[no-untyped-def]
    """Extend until a lane waits; return it: one that has ended, or an idle one to draw a node for.

    All that have ended come first, then the idle ones, and then the others go on: so what is done
    does not depend on where a slice of time ends.

    Args:
        search, tree, min_steps, least: As ``extend_all`` takes them.
    """
    draws = tree.extensions.draws
    while True:
        drawn = 0
        for lane in range(LANES):
            drawn += draws[lane]
        for lane in range(LANES):
            if drawn == 0 and has_ended(tree, lane):
                return lane
        for lane in range(LANES):
            # draws of a node to extend, in an idle lane before the others go on
            if is_idle(tree, lane) and draws[lane] < 8:
                return lane
        extend_all(search, tree, min_steps, least)
