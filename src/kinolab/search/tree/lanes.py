"""Several states at once, a lane for each: inputs from one node, and extensions of several nodes.

The states are those that one input after the other would lead to, bit for bit.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.integrators import LANES
from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.numerics.rng import below
from kinolab.search.tree.flat_arrays import copy
from kinolab.search.tree.problem_arrays import sample_control
from kinolab.simulation.machine import advance, advance_in_lanes

NOWHERE = -1  # no lane


class LaneStates(NamedTuple):
    """Scratch memory for compiled kernels: states and inputs, entry by entry."""

    now: Annotated[Array, "nx", LANES]
    after: Annotated[Array, "nx", LANES]
    held: Annotated[Array, "nu", LANES]
    steps: Annotated[Integers, LANES]  # steps of a lane; 0 once it has ended early
    least: Annotated[Array, LANES]  # cost of its input
    nearest: Annotated[Array, LANES]  # scratch
    best: Annotated[Integers, LANES]  # steps to be made of it
    track: Annotated[Array, "steps", "nx", LANES]  # states after each step, where they are kept
    chosen: Annotated[Array, "steps", "nx"]  # those of the input that is held
    slope: Annotated[Array, "nx", LANES]  # derivatives at LANES of these


class Extensions(NamedTuple):
    """Extensions under way, one in each lane, for compiled kernels."""

    now: Annotated[Array, "nx", LANES]  # where they are
    after: Annotated[Array, "nx", LANES]  # where the next step leads
    held: Annotated[Array, "nu", LANES]
    slope: Annotated[Array, "nx", LANES]  # derivative of the state where they are
    slope_after: Annotated[Array, "nx", LANES]
    parent: Annotated[Integers, LANES]  # NONE for a lane that is idle
    steps: Annotated[Integers, LANES]  # to be made at most
    made: Annotated[Integers, LANES]
    ended: Annotated[NDArray[np.uint8], LANES]  # whether no more are made
    clearance: Annotated[Array, LANES]  # known, in [m]
    speed: Annotated[Array, LANES]  # bound on the speed of points, in [m/s]
    violation: Annotated[Array, LANES]  # normalised goal error
    draws: Annotated[Integers, LANES]  # of a node to extend, since the others went on


@kernel
def drop_extensions(extensions):  # type: ignore[no-untyped-def]
    """Make all lanes idle."""
    for lane in range(LANES):
        extensions.parent[lane], extensions.draws[lane] = -1, 0


@kernel
def draw_control(search, u, min_steps, max_steps):  # type: ignore[no-untyped-def]
    """Draw an input, written to ``u`` (nu,), and return for how many steps it is held.

    Args:
        search: ``SearchState``.
        u: The input; written.
        min_steps, max_steps: Range of the control duration in steps.
    """
    sample_control(search.problem, search.random, u)
    return min_steps + below(search.random, max_steps - min_steps + 1)


@kernel
def draw_lanes(search, tree, parent, inputs, min_steps, max_steps):  # type: ignore[no-untyped-def]
    """Begin every lane at a node, with an input of its own; return the most steps of any.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        parent: The node.
        inputs: Number of inputs to draw; lanes beyond it have no steps.
        min_steps, max_steps: Range of the control duration in steps.
    """
    lanes, most = tree.lanes, 0
    for lane in range(LANES):
        lanes.steps[lane] = 0
        if lane < inputs:
            lanes.steps[lane] = draw_control(search, tree.drawn, min_steps, max_steps)
            most = max(most, lanes.steps[lane])
        copy(tree.drawn, lanes.held[:, lane])
        copy(tree.x[parent], lanes.now[:, lane])
    return most


@kernel
def advance_lanes(search, tree, step, now, after):  # type: ignore[no-untyped-def]
    """Make a step in every lane that has one left; return bits that are set where that fails.

    A machine without code for several states at once makes their steps one by one.

    Args:
        search, tree: ``SearchState`` and ``Tree``.
        step: Number of steps made before.
        now, after: States before it and after it, shape (nx, LANES) each; the latter written.
    """
    machine, h, lanes, failed = search.machine, search.problem.step, tree.lanes, np.int64(0)
    if machine.step_in_lanes != 0:
        return np.int64(advance_in_lanes(machine, now, lanes.held, h, after))
    for lane in range(LANES):
        if step < lanes.steps[lane]:
            copy(now[:, lane], tree.now)
            copy(lanes.held[:, lane], tree.drawn)
            if advance(machine, tree.now, tree.drawn, h, tree.after) != 0:
                failed |= 1 << lane
            copy(tree.after, after[:, lane])
    return failed


@kernel
def hold_best_lane(tree, inputs, least, longest):  # type: ignore[no-untyped-def]
    """Write the input of the lane of least cost to ``tree.held``, if none before cost as little.

    Args:
        tree: Its lanes have costs, and the steps to there.
        inputs: Number of lanes in use.
        least, longest: Cost of the best input before, and its number of steps; 0 for none.

    Returns:
        Cost and number of steps of the best input so far, and its lane, NOWHERE if it is not new.
    """
    lanes, held = tree.lanes, NOWHERE
    for lane in range(inputs):
        if longest == 0 or lanes.least[lane] < least:
            least, longest, held = lanes.least[lane], lanes.best[lane], lane
            copy(lanes.held[:, lane], tree.held)
    return least, longest, held
