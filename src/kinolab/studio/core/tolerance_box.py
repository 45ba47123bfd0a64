"""Where the tolerances of a goal let the machine be."""

from __future__ import annotations

from itertools import product

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask


def tolerance_box(problem: PlanningTask) -> Array | None:
    """Return two corners of a box in which the leading body may be at the goal, shape (2, 3).

    It has the places at all ends of the tolerances of coordinates, in [m]; what the goal leaves
    free is as in its centre. None where nothing decides the place but targets, which are drawn.
    """
    goal, nq = problem.goal, problem.model.nq
    reach = dict(zip(goal.indices, goal.tolerances.tolist(), strict=True))
    # coordinates whose tolerances are combined: 256 poses
    decided = [i for i in goal.entries if i < nq and i in reach][:8]
    if goal.points or goal.directions or not decided:
        return None
    centre = goal.centre(problem.start)
    ends = np.array(list(product((-1.0, 1.0), repeat=len(decided))))
    states = np.repeat(centre[None], len(ends), axis=0)
    states[:, decided] += ends * [reach[i] for i in decided]
    places = problem.model.frames(states)[:, problem.leading, 3::4]
    corners = np.array([places.min(axis=0), places.max(axis=0)])
    # 1e-9 [m]: what moves less stays where it is
    moves = np.isfinite(corners).all() and np.ptp(corners, axis=0).max() > 1e-9
    return corners if moves else None
