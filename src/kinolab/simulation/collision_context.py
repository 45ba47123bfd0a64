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

from kinolab.numerics.jit import kernel
from kinolab.problem import Problem
from kinolab.simulation.machine import advance, call_at, call_under
from kinolab.simulation.safety_factor import CAUTION, moves_upright, resolution
from kinolab.world.collision.clearance_bound import (
    Scratch,
    Surroundings,
    room_within,
    scratch_for,
    surroundings,
)
from kinolab.world.collision.triangle_grid import Integers
from kinolab.world.geometry import Array

FAR = 1.0  # [m] of room that is looked for at most where a step needs less
FINE = 0.25  # of a cell: room that the grid shows and is not worked out


class Looks(NamedTuple):
    """Scratch memory for looks at a machine."""

    x: Array  # (nx,) a state within a step
    speeds: Array  # (bodies + cables,)
    poses: Array  # (bodies, 12)
    ends: Array  # (cables, 6)
    scratch: Scratch


class Ways(NamedTuple):
    """What is in the way of a machine, for compiled code."""

    all_around: Surroundings
    axis: Integers  # (limits,) x, y, z that the workspace limits, as entries of a pose
    lower: Array  # (limits,) in [m]
    upper: Array  # (limits,)
    tight: float  # [m] of room that is asked for
    farthest: float  # [m] that points may move between two looks, whatever the room is
    fine: float  # [m] of room that is not worked out more closely
    far: float  # [m] of room that is looked for, to spare later looks


def ways_of(problem: Problem) -> Ways:
    """Gather what is in the way of a problem's machine."""
    world, spacing = problem.world, resolution(problem)
    limits = [("xyz".index(axis), *pair) for axis, pair in world.bounds.items()]
    all_around = surroundings(
        problem.bodies,
        world,
        cables=problem.cables,
        self_pairs=problem.system.collisions,
        glides=not moves_upright(problem, touching=False),
    )
    return Ways(
        all_around=all_around,
        axis=np.array([4 * axis + 3 for axis, *_ in limits], dtype=np.int64),
        lower=np.array([lower for _, lower, _ in limits], dtype=float),
        upper=np.array([upper for *_, upper in limits], dtype=float),
        tight=spacing / 2,
        # A foot may come down to the ground and no further: only fine looks tell the difference.
        farthest=spacing if moves_upright(problem, touching=True) else math.inf,
        fine=max(FINE * all_around.distance.width, spacing),
        far=FAR,
    )


def looks_at(problem: Problem, ways: Ways, poses: Array, ends: Array) -> Looks:
    """Return scratch memory for looks at a problem's machine; one for every thread."""
    return Looks(
        x=np.zeros(problem.model.nx),
        speeds=np.zeros(max(len(poses), len(ends), 1)),
        poses=poses,
        ends=ends,
        scratch=scratch_for(ways.all_around),
    )


@kernel
def place_at(machine, x, looks):  # type: ignore[no-untyped-def]
    """Set the poses and the ends of cables at a state."""
    call_at(machine.frames, x.ctypes.data, machine.p.ctypes.data, looks.poses.ctypes.data)
    if looks.ends.shape[0]:
        call_at(machine.cables, x.ctypes.data, machine.p.ctypes.data, looks.ends.ctypes.data)


@kernel
def room_at(wanted, need, looks, ways):  # type: ignore[no-untyped-def]
    """Bound the room of a placed machine, the workspace included, as ``room_within`` does."""
    best = need
    for k in range(ways.axis.shape[0]):
        for b in range(looks.poses.shape[0]):
            at = looks.poses[b, ways.axis[k]]
            inside = min(at - ways.lower[k], ways.upper[k] - at)
            if not inside >= 0.0:  # NaN included
                return -1.0
            best = min(best, max(inside, ways.tight))
    return room_within(
        looks.poses, looks.ends, ways.tight, wanted, best, ways.fine,
        looks.scratch, ways.all_around,
    )  # fmt: skip


@kernel
def fastest_at(machine, x, u, looks):  # type: ignore[no-untyped-def]
    """Bound the speed of a machine's points at a state under inputs, in [m/s].

    The ends of a cable bound its points: each is a mean of the two, and so is its velocity.
    """
    bodies, cables, largest = looks.poses.shape[0], looks.ends.shape[0], 0.0
    p, out = machine.p.ctypes.data, looks.speeds.ctypes.data
    call_under(machine.point_speed, x.ctypes.data, u.ctypes.data, p, out)
    for b in range(bodies):
        largest = max(largest, looks.speeds[b])
    if cables:
        call_under(machine.cable_speed, x.ctypes.data, u.ctypes.data, p, out)
        for c in range(cables):
            largest = max(largest, looks.speeds[c])
    return largest


@kernel
def free_on_the_way(machine, x, u, after, h, spare, speed, looks, ways):  # type: ignore[no-untyped-def]
    """Say whether the step from x to ``after`` in h [s] is free; the poses are those that are not.

    The speed of its points within the step is taken to be at most CAUTION times that at its ends.

    Args:
        machine, looks, ways: The machine and what is in its way.
        x, u, after: State (nx,), inputs (nu,) and the state reached (nx,).
        h: In [s].
        spare: Room at x in [m], as far as it is known; 0 where it is not.
        speed: That of the fastest point at x, in [m/s].

    Returns:
        Room at ``after`` in [m], negative where the way is not free; and the speed there.
    """
    then = fastest_at(machine, after, u, looks)
    speed = CAUTION * max(speed, then)
    if spare - speed * h >= ways.tight:
        return spare - speed * h, then
    place_at(machine, after, looks)
    left, at_end = h, -1.0
    while True:
        reach = speed * left
        room = min(room_at(reach, max(reach, ways.far), looks, ways), ways.farthest)
        if not room >= ways.tight:
            return -1.0, then
        if at_end < 0.0:
            at_end = room
        if room >= reach:
            return at_end, then
        # The next look has as much room as is asked for, or the step is not free.
        left -= (room + ways.tight) / speed
        if left <= 0.0 or speed * left <= spare:
            return at_end, then
        advance(machine, x, u, left, looks.x)
        place_at(machine, looks.x, looks)
