"""Is the way of one step free? As far as the room reaches, it is; then the next look.

At every look the machine has some room, and stays free for as long as no point of it moves further
than that. So the looks go back from the end of the step to its beginning, each as far from the one
before as its room allows.

Source: Mirtich, Impulse-based dynamic simulation of rigid body systems, 1996 (conservative
advancement).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.problem import PlanningTask
from kinolab.simulation.continuous_collision import SAFETY_FACTOR, moves_upright, resolution
from kinolab.simulation.machine import advance, call_at, call_under
from kinolab.world.collision.clearance_bound import clearance_within
from kinolab.world.collision.collision_scene import (
    CollisionScene,
    Scratch,
    collision_scene,
    scratch_for,
)
from kinolab.world.collision.triangle_grid import Integers

CLEARANCE_HORIZON = 1.0  # [m] of room that is looked for at most where a step needs less
COARSE_CELL_FRACTION = 0.25  # of a cell: room that the grid shows and is not worked out


class CollisionScratch(NamedTuple):
    """Scratch memory for looks at a machine."""

    x: Array  # (nx,) a state within a step
    speeds: Array  # (bodies + cables,)
    poses: Array  # (bodies, 12)
    ends: Array  # (cables, 6)
    clearance_scratch: Scratch


class CollisionContext(NamedTuple):
    """What is in the way of a machine, for compiled code."""

    scene: CollisionScene
    axis: Integers  # (limits,) x, y, z that the workspace limits, as entries of a pose
    lower: Array  # (limits,) in [m]
    upper: Array  # (limits,)
    required_clearance: float  # [m] of room that is asked for
    max_step: float  # [m] that points may move between two looks, whatever the room is
    coarse_clearance: float  # [m] of room that is not worked out more closely
    clearance_horizon: float  # [m] of room that is looked for, to spare later looks


def collision_context(problem: PlanningTask) -> tuple[CollisionContext, CollisionScratch]:
    """Gather what is in the way of a problem's machine, with scratch memory for one thread."""
    world, spacing = problem.world, resolution(problem)
    gliding = not moves_upright(problem, touching=False)
    # A foot may come down to the ground and no further: only fine checks tell the difference.
    max_step = spacing if moves_upright(problem, touching=True) else math.inf
    limits = [("xyz".index(axis), *pair) for axis, pair in world.bounds.items()]
    all_around = collision_scene(
        problem.bodies,
        world,
        cables=problem.cables,
        self_pairs=problem.system.collisions,
        glides=gliding,
    )
    bodies, cables = len(problem.bodies), len(problem.cables)
    scratch = CollisionScratch(
        x=np.zeros(problem.model.nx),
        speeds=np.zeros(max(bodies, cables, 1)),
        poses=np.zeros((bodies, 12)),
        ends=np.zeros((cables, 6)),
        clearance_scratch=scratch_for(all_around),
    )
    context = CollisionContext(
        scene=all_around,
        axis=np.array([4 * axis + 3 for axis, *_ in limits], dtype=np.int64),
        lower=np.array([lower for _, lower, _ in limits], dtype=float),
        upper=np.array([upper for *_, upper in limits], dtype=float),
        required_clearance=spacing / 2,
        max_step=max_step,
        coarse_clearance=max(COARSE_CELL_FRACTION * all_around.distance.width, spacing),
        clearance_horizon=CLEARANCE_HORIZON,
    )
    return context, scratch


@kernel
def place_machine(machine, x, scratch):  # type: ignore[no-untyped-def]
    """Set the poses and the ends of cables at a state."""
    call_at(machine.frames, x.ctypes.data, machine.p.ctypes.data, scratch.poses.ctypes.data)
    if scratch.ends.shape[0]:
        call_at(machine.cables, x.ctypes.data, machine.p.ctypes.data, scratch.ends.ctypes.data)


@kernel
def clearance_bound(wanted, need, scratch, context):  # type: ignore[no-untyped-def]
    """Bound the room of a placed machine, the workspace included, as ``clearance_within`` does."""
    best = need
    for k in range(context.axis.shape[0]):
        for b in range(scratch.poses.shape[0]):
            at = scratch.poses[b, context.axis[k]]
            inside = min(at - context.lower[k], context.upper[k] - at)
            if not inside >= 0.0:  # NaN included
                return -1.0
            best = min(best, max(inside, context.required_clearance))
    return clearance_within(
        scratch.poses, scratch.ends, context.required_clearance, wanted, best,
        context.coarse_clearance,
        scratch.clearance_scratch, context.scene,
    )  # fmt: skip


@kernel
def speed_bound(machine, x, u, scratch):  # type: ignore[no-untyped-def]
    """Bound the speed of a machine's points at a state under inputs, in [m/s].

    The ends of a cable bound its points: each is a mean of the two, and so is its velocity.
    """
    bodies, cables, largest = scratch.poses.shape[0], scratch.ends.shape[0], 0.0
    p, out = machine.p.ctypes.data, scratch.speeds.ctypes.data
    call_under(machine.point_speed, x.ctypes.data, u.ctypes.data, p, out)
    for b in range(bodies):
        largest = max(largest, scratch.speeds[b])
    if cables:
        call_under(machine.cable_speed, x.ctypes.data, u.ctypes.data, p, out)
        for c in range(cables):
            largest = max(largest, scratch.speeds[c])
    return largest


@kernel
def is_motion_free(machine, x, u, after, h, spare, speed, scratch, context):  # type: ignore[no-untyped-def]
    """Say whether the step from x to ``after`` in h [s] is free; the poses are those that are not.

    The speed of its points within the step is taken to be at most CAUTION times that at its ends.

    Args:
        machine, scratch, context: The machine and what is in its way.
        x, u, after: State (nx,), inputs (nu,) and the state reached (nx,).
        h: In [s].
        spare: Room at x in [m], as far as it is known; 0 where it is not.
        speed: That of the fastest point at x, in [m/s].

    Returns:
        Room at ``after`` in [m], negative where the way is not free; and the speed there.
    """
    then = speed_bound(machine, after, u, scratch)
    speed = SAFETY_FACTOR * max(speed, then)
    if spare - speed * h >= context.required_clearance:
        return spare - speed * h, then
    place_machine(machine, after, scratch)
    left, at_end = h, -1.0
    while True:
        reach = speed * left
        clearance = min(
            clearance_bound(reach, max(reach, context.clearance_horizon), scratch, context),
            context.max_step,
        )
        if not clearance >= context.required_clearance:
            return -1.0, then
        if at_end < 0.0:
            at_end = clearance
        if clearance >= reach:
            return at_end, then
        # The next look has as much room as is asked for, or the step is not free.
        left -= (clearance + context.required_clearance) / speed
        if left <= 0.0 or speed * left <= spare:
            return at_end, then
        advance(machine, x, u, left, scratch.x)
        place_machine(machine, scratch.x, scratch)
