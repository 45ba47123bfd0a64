"""Continuous collision check of one step by conservative advancement, in compiled code.

At every check the machine stays free for as long as no point of it moves further than its
clearance. So checks proceed from the end of the step back to its beginning, each as far from the
previous one as that clearance allows.

Source: Mirtich, Impulse-based dynamic simulation of rigid body systems, 1996 (conservative
advancement).
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array, Integers, allocate
from kinolab.numerics.jit import kernel
from kinolab.problem import PlanningTask
from kinolab.simulation.machine import advance, call_at, call_under
from kinolab.world.collision.broadphase import Scratch
from kinolab.world.collision.clearance_bound import clearance_within
from kinolab.world.collision.collision_scene import CollisionScene, collision_scene
from kinolab.world.distances.placed_shapes import lowest_heights

MIN_RESOLUTION = 1e-4  # [m], where the start is close to an obstacle
RANDOM_STATES = 20  # at which bodies' heights are compared
SAFETY_FACTOR = 1.1  # on speeds at both ends of a step, for those in between
CLEARANCE_HORIZON = 1.0  # [m] up to which clearance is computed, to skip later checks


class CollisionScratch(NamedTuple):
    """Scratch memory for collision checks of a machine."""

    x: Annotated[Array, "nx"]  # a state within a step
    speeds: Annotated[Array, "parts"]
    poses: Annotated[Array, "bodies", 12]
    ends: Annotated[Array, "cables", 6]
    clearance_scratch: Scratch


class CollisionContext(NamedTuple):
    """Collision scene, workspace limits and resolution of a machine, for compiled code."""

    scene: CollisionScene
    axis: Integers  # (limits,) x, y, z that the workspace limits, as entries of a pose
    lower: Array  # (limits,) in [m]
    upper: Array  # (limits,)
    bodies: Integers  # that the workspace limits
    required_clearance: float  # [m] at every check
    max_step: float  # [m] that points may move between two checks, whatever the clearance
    coarse_clearance: float  # [m] above which the grid's bound is not refined


def collision_context(
    problem: PlanningTask, margin: float = 0.0, finest: float = math.inf
) -> tuple[CollisionContext, CollisionScratch]:
    """Build the collision context of a problem, with scratch memory for one thread.

    Args:
        margin: Additional clearance in [m].
        finest: As ``resolution`` takes it: passages half as wide count as free.
    """
    world, spacing = problem.world, resolution(problem, finest)
    upright = [problem.bodies[k].touches_ground for k in moving_upright(problem)]
    # A foot may touch the ground but not sink: only fine checks tell the difference.
    max_step = spacing if any(upright) else math.inf
    limits = [("xyz".index(axis), *pair) for axis, pair in world.bounds.items()]
    all_around = collision_scene(
        problem.bodies,
        world,
        cables=problem.cables,
        self_pairs=problem.machine.collisions,
        glides=all(upright),  # but for what touches the ground
    )
    bodies, cables = len(problem.bodies), len(problem.cables)
    sizes = {"nx": problem.model.nx, "bodies": bodies, "cables": cables, "pairs": 1}
    sizes |= {"parts": max(bodies, cables, 1), "shapes": len(all_around.broadphase.kind)}
    context = CollisionContext(
        scene=all_around,
        axis=np.array([4 * axis + 3 for axis, *_ in limits], dtype=np.int64),
        lower=np.array([lower for _, lower, _ in limits], dtype=float),
        upper=np.array([upper for *_, upper in limits], dtype=float),
        bodies=problem.moving.astype(np.int64),
        required_clearance=margin + spacing / 2,
        max_step=max_step,
        # of a cell: clearance for which the grid's bound suffices
        coarse_clearance=max(0.25 * all_around.distance.width, spacing),
    )
    return context, allocate(CollisionScratch, sizes)


def resolution(problem: PlanningTask, finest: float = math.inf) -> float:
    """Return the spacing of checks in [m]: the clearance of the start, clipped.

    Args:
        finest: Another one in [m], where that of the problem is coarser.
    """
    # [m] that a point may move between two checks, at the finest level
    clearance = problem.checker().clearance(*problem.placement(problem.start), 0.01)
    return max(min(clearance, finest), MIN_RESOLUTION)


def moving_upright(problem: PlanningTask) -> list[int]:
    """Return the bodies whose lowest point changes height over the ground; none without one.

    Bodies that stay at one height need no margin against the ground, which would block them.
    """
    if not problem.world.ground:
        return []
    generator, nq = np.random.default_rng(0), problem.model.nq
    states = problem.sample_goals(generator, np.ones(RANDOM_STATES))
    states[:, :nq] += generator.normal(size=(RANDOM_STATES, nq))
    poses = problem.frames(states).reshape(RANDOM_STATES, -1, 3, 4)
    # Not finite: some sampled states have no pose, which says nothing about heights.
    return [
        k
        for k, body in enumerate(problem.bodies)
        for shape in body.shapes
        if not np.ptp(lowest_heights(shape, poses[:, k])) <= MIN_RESOLUTION
    ]


@kernel
def place_machine(machine, x, scratch):  # type: ignore[no-untyped-def]
    """Compute body poses and cable ends at a state (nx,) into ``scratch``."""
    call_at(machine.frames, x.ctypes.data, machine.p.ctypes.data, scratch.poses.ctypes.data)
    if scratch.ends.shape[0]:
        call_at(machine.cables, x.ctypes.data, machine.p.ctypes.data, scratch.ends.ctypes.data)


@kernel
def clearance_bound(wanted, need, scratch, context):  # type: ignore[no-untyped-def]
    """Bound a placed machine's clearance, workspace included, as ``clearance_within``."""
    best = need
    for k in range(context.axis.shape[0]):
        for b in context.bodies:
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
    """Bound the speed of a machine's points at x (nx,) under u (nu,), in [m/s].

    A cable's ends bound it: each point's velocity is a convex combination of theirs.
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
    """Check the step from x to ``after``; on collision ``scratch`` holds the colliding poses.

    Point speeds within the step are taken to be at most SAFETY_FACTOR times those at its ends.

    Args:
        machine, scratch, context: The machine and its collision context.
        x, u, after: State (nx,), inputs (nu,) and next state (nx,).
        h: Step length in [s].
        spare: Known clearance at x in [m]; 0 where unknown.
        speed: Bound on point speeds at x, in [m/s].

    Returns:
        Clearance at ``after`` in [m], negative on collision; and the speed bound there in [m/s].
    """
    then = speed_bound(machine, after, u, scratch)
    speed = SAFETY_FACTOR * max(speed, then)
    # checks; a step of more, such as one of years, is refused
    if not speed * h <= 1_000_000 * context.required_clearance:  # NaN included
        return -1.0, then
    if spare - speed * h >= context.required_clearance:
        return spare - speed * h, then
    place_machine(machine, after, scratch)
    left, at_end = h, -1.0
    while True:
        reach = speed * left
        clearance = min(
            clearance_bound(reach, max(reach, CLEARANCE_HORIZON), scratch, context),
            context.max_step,
        )
        if not clearance >= context.required_clearance:
            return -1.0, then
        if at_end < 0.0:
            at_end = clearance
        if clearance >= reach:
            return at_end, then
        # The next check must find the required clearance, or the step is not free.
        left -= (clearance + context.required_clearance) / speed
        if left <= 0.0 or speed * left <= spare:
            return at_end, then
        advance(machine, x, u, left, scratch.x)
        place_machine(machine, scratch.x, scratch)
