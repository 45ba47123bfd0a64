"""Motions along paths of fully actuated machines, by inputs that the equations of motion give.

Source: Lynch, Park, Modern Robotics, 2017, sections 9.2 (straight paths with a time scaling) and
11.4 (computed torque).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.trajopt.multistart.rest_to_rest import LegCurve, timed
from kinolab.trajopt.nlp.decision import Knots

SAMPLES = 16  # configurations of a leg between its ends and at them
SHORT = 1e-6  # of a coordinate's scale: corners closer together are one


def along_corners(problem: PlanningTask, path: Array) -> Knots | None:
    """Return a motion from corner to corner with stops between; None if inputs do not suffice.

    Args:
        problem: The planning problem of a machine that follows every path.
        path: Corners, shape (m, nx).
    """
    nq, parts = problem.model.nq, []
    fractions = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    for begin, end in pairwise(path[:, :nq]):
        if (np.abs(end - begin) <= SHORT * problem.scales[:nq]).all():
            continue
        q = begin + fractions * (end - begin)
        curve = LegCurve.through(problem, q, np.tile(end - begin, (SAMPLES, 1)))
        part = timed(problem, curve)
        if part is None:
            return None
        parts.append(part)
    if not parts:
        return None
    x = np.vstack([parts[0].x[:1], *(part.x[1:] for part in parts)])
    return Knots(x, np.vstack([part.u for part in parts]), parts[0].h)
