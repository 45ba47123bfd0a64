"""How much room is asked for where a motion is judged by looks at some of its states."""

from __future__ import annotations

import numpy as np

from kinolab.problem import Problem
from kinolab.world import lowest_z

RESOLUTION = 0.01  # [m] that a point may move between two looks, where it is tight
MIN_RESOLUTION = 1e-4  # [m] of the same where the start is close to an obstacle
RANDOM_STATES = 20  # drawn at random to see whether bodies rise and sink
SAFETY_FACTOR = 1.1  # factor on what is measured at both ends of a step, for what lies in between


def resolution(problem: Problem) -> float:
    """Return the spacing of checks: fine enough that the start has room for half of it."""
    clearance = problem.checker().clearance(*problem.placement(problem.start))
    return float(np.clip(clearance, MIN_RESOLUTION, RESOLUTION))


def moves_upright(problem: Problem, *, touching: bool) -> bool:
    """Say whether a body's lowest point rises and sinks, of those that may touch the ground or not.

    Margins against the ground would be in the way of what glides at one height.
    """
    chosen = [k for k, body in enumerate(problem.bodies) if body.touches_ground is touching]
    if not (problem.world.ground and chosen):
        return False
    generator, nq = np.random.default_rng(0), problem.model.nq
    states = np.array([problem.sample_goal(generator) for _ in range(RANDOM_STATES)])
    states[:, :nq] += generator.normal(size=(RANDOM_STATES, nq))
    poses = problem.frames(states)[:, chosen].reshape(RANDOM_STATES, len(chosen), 3, 4)
    lowest = [
        [lowest_z(shape, pose[k]) for pose in poses]
        for k, body in enumerate(chosen)
        for shape in problem.bodies[body].shapes
    ]
    # Not finite: the machine has no pose at some of the states, which says nothing about heights.
    return bool(lowest) and not np.ptp(lowest, axis=1).max() <= MIN_RESOLUTION
