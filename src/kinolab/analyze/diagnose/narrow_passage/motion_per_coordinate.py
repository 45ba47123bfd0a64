"""How far each coordinate moves the points of a machine and of its goal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.world import feature_points

FD_STEP = 1e-5  # [m] or [rad]


def motion_per_coordinate(problem: PlanningTask, states: Sequence[Array]) -> Array:
    """Return the largest point displacement per m or rad of each coordinate, shape (nx,).

    It is 0 for coordinates that affect neither the shapes' poses nor the goal, such as a wheel's
    roll angle, and for velocities. The four entries of an attitude have the value of its angle.

    Args:
        states: Where it is evaluated, in addition to random configurations.
    """
    generator = np.random.default_rng(0)
    # 12 random samples, in addition to those given
    samples = [*states, *(problem.sample(generator) for _ in range(12))]
    far = np.zeros(problem.model.nx)
    for i in range(problem.model.nq):
        far[i] = max(_moved(problem, x, i) for x in samples)
    for part in problem.space.spheres:
        far[part.own] = far[part.own].max() / part.angles  # an angle turns an entry by half
    far[far < 1e-7] = 0.0  # [m] per unit: smaller displacements are rounding
    wanted = [i for i in problem.goal.entries if i < problem.model.nq]
    # 0.01 [m] per unit, for coordinates that only the goal depends on
    far[wanted] = np.maximum(far[wanted], 0.01)
    return far


def _moved(problem: PlanningTask, x: Array, i: int) -> float:
    """Return the largest point displacement per unit of one coordinate."""
    nudged = x.copy()
    nudged[i] += FD_STEP
    before, after = (_points(problem, state) for state in (x, problem.model.project(nudged)))
    moved = np.linalg.norm(after - before, axis=1)
    return float(np.nan_to_num(moved).max(initial=0.0)) / FD_STEP


def _points(problem: PlanningTask, x: Array) -> Array:
    """Return world points that determine the machine's shapes and goal errors, shape (n, 3)."""
    poses, ends = problem.placement(x)
    places = [
        pose.reshape(3, 4) @ np.concatenate([points, np.ones((len(points), 1))], axis=1).T
        for body, pose in zip(problem.bodies, poses, strict=True)
        for points in map(feature_points, body.shapes)
    ]
    goal = problem.goal
    asked = [(p.body, p.at, 1.0) for p in goal.points]
    asked += [(d.body, d.axis, 0.0) for d in goal.directions]
    asked += [(cone.body, cone.axis, 0.0) for cone in problem.keep_outs]
    places += [poses[b].reshape(3, 4) @ np.array([[*at, shift]]).T for b, at, shift in asked]
    return np.concatenate([*(place.T for place in places), ends.reshape(-1, 3)])
