"""How near a motion comes to obstacles, between its knots too."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import PlanningTask
from kinolab.simulation.reference import reference_motion
from kinolab.trajectory import Trajectory

Array: TypeAlias = NDArray[np.float64]

SPACING = 1e-3  # [m] of motion between two looks, at most
PROBES = 5  # of the speed within one step
CAUTION = 1.2  # factor on the fastest probe


def clearance(problem: PlanningTask, trajectory: Trajectory) -> float:
    """Return the smallest distance to an obstacle in [m]; infinite without obstacles, 0 inside.

    It is at most half of SPACING too large. Steps in which no point can come nearer than the
    nearest so far are not looked into.
    """
    motion = reference_motion(problem, trajectory.x[0], trajectory.t, trajectory.u)
    checker = problem.checker()

    def room(x: Array) -> float:
        return checker.clearance(*problem.placement(x))

    at_knots = [room(x) for x in motion.x]
    best = min(at_knots)
    for k, held in enumerate(trajectory.u):
        begin, end = float(motion.t[k]), float(motion.t[k + 1])
        probes = motion.between(k, np.linspace(begin, end, PROBES))
        way = CAUTION * float(np.max(problem.model.point_speed(probes, held))) * (end - begin)
        if not math.isfinite(best) or (at_knots[k] + at_knots[k + 1] - way) / 2 >= best:
            continue
        times = np.linspace(begin, end, math.ceil(way / SPACING) + 1)[1:-1]
        best = min([best, *(room(x) for x in motion.between(k, times))])
    return best
