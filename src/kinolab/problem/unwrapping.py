"""One state can be written in many numbers: whole turns of an angle, either sign of a quaternion.

A motion reads best, and is interpolated and tracked right, in numbers without jumps.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinolab.errors import SingularError
from kinolab.numerics.arrays import Array
from kinolab.problem.task import PlanningTask
from kinolab.trajectory import Trajectory

MAX_ANGLE = 1e12  # [rad] of an angle that is known to a thousandth


def unwrapped(problem: PlanningTask, trajectory: Trajectory) -> Trajectory:
    """Return the same motion in numbers that do not jump from knot to knot.

    The first knot is written like the problem's start, every other one like what the knot before
    and the rates of both lead to: a wheel may turn more than once between two knots. A motion that
    does not jump keeps its numbers, to the bit, and so does one with numbers that are no angles any
    more: not finite, or so large that whole turns are lost in rounding.

    Args:
        problem: Whose motion it is.
        trajectory: Its knots, written in any way.
    """
    turning = problem.circular.any() or problem.model.attitudes
    if not turning or not (np.abs(trajectory.x) < MAX_ANGLE).all():
        return trajectory
    x = np.array(trajectory.x, dtype=float)
    near = problem.start
    for k, turned in enumerate([np.zeros(x.shape[1]), *_turned(problem, trajectory)]):
        x[k] = problem.space.nearest(near + turned, x[k])
        near = x[k]
    return replace(trajectory, x=x)


def _turned(problem: PlanningTask, trajectory: Trajectory) -> Array:
    """Return by how much circular coordinates turn in each interval, shape (N, nx).

    By the trapezoidal rule; where the rates are unknown, nothing is said to turn.
    """
    model, (x, u) = problem.model.plant, (trajectory.x, trajectory.u)
    turned, spans = np.zeros((len(u), x.shape[1])), np.diff(trajectory.t)
    entries = np.flatnonzero(problem.circular)
    rates = [model.rate_names.index(f"{model.state_names[i]}_dot") for i in entries]
    try:
        speeds = (model.velocity(x[:-1], u) + model.velocity(x[1:], u)) / 2
    except SingularError:
        return turned
    turned[:, entries] = spans[:, None] * speeds[:, rates]
    return turned
