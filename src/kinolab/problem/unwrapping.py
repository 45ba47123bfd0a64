"""Unwrapping of trajectories: angles without jumps by whole turns, quaternions without sign flips.

Interpolation and tracking need representations that are continuous from knot to knot.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinolab.errors import SingularError
from kinolab.numerics.arrays import Array
from kinolab.problem.task import PlanningTask
from kinolab.trajectory import Trajectory


def unwrapped(problem: PlanningTask, trajectory: Trajectory) -> Trajectory:
    """Return the same motion in a representation without jumps from knot to knot.

    The first knot follows the problem's start, every other one the prediction from the previous
    knot and both knots' rates: a wheel may turn more than once between two knots. A motion without
    jumps is returned bit for bit, as is one with values that are not finite or so large that whole
    turns are lost in rounding.

    Args:
        trajectory: Knots in any representation.
    """
    # [rad] beyond which rounding exceeds a thousandth
    if not problem.space.turns.any() or not (np.abs(trajectory.x) < 1e12).all():
        return trajectory
    x = np.array(trajectory.x, dtype=float)
    near = problem.start
    for k, turned in enumerate([np.zeros(x.shape[1]), *_turned(problem, trajectory)]):
        x[k] = problem.space.nearest(near + turned, x[k])
        near = x[k]
    return replace(trajectory, x=x)


def _turned(problem: PlanningTask, trajectory: Trajectory) -> Array:
    """Predict the increment of circular coordinates per interval, shape (N, nx).

    By the trapezoidal rule; zero where the rates are unknown.
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
