"""Paths turned so that a machine whose wheels do not slip may follow them: turn, drive, turn."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.trajopt.multistart.allowed_velocities import velocity_directions
from kinolab.trajopt.options import GUESS


def turned_along(problem: PlanningTask, path: Array) -> Array:
    """Return a path on which a heading follows the legs that constraints would forbid otherwise.

    For each leg, every angle on the circle is tried as the heading: the others' velocities must lie
    in the span of what the constraints allow. Of several headings, such as forward and backward,
    the nearest to the one before is taken.

    Args:
        problem: The planning problem.
        path: Shape (m, nx).

    Returns:
        The same path where no angle makes a leg possible; else with a turn on the spot before it.

    Source: Laumond (ed.), Robot Motion Planning and Control, 1998, chapter 1 (the paths that a
    robot on two driven wheels follows).
    """
    nq = problem.model.nq
    matters = np.flatnonzero(~cyclic_coordinates(problem)[:nq])
    circles = [int(i) for i in np.flatnonzero(problem.circular[:nq]) if i in matters]
    if not circles or nq == problem.model.nx:
        return path
    made, turned = [path[0]], False
    for begin, end in pairwise(path):
        leg = _turned(problem, begin, end, made[-1], circles, matters)
        made += [end] if leg is None else leg
        turned |= leg is not None
    if not turned:
        return path  # with its whole turns
    return problem.space.continuous(np.stack([*made, path[-1]]))


def _turned(
    problem: PlanningTask,
    begin: Array,
    end: Array,
    before: Array,
    circles: list[int],
    matters: NDArray[np.int64],
) -> list[Array] | None:
    """Return a leg's ends with a heading along it; None if it needs none, or none is found."""
    middle = (begin + end) / 2
    if _forbidden(problem, middle[None], end - begin, matters)[0] <= GUESS.sideways:
        return None
    headings = np.linspace(-np.pi, np.pi, GUESS.headings, endpoint=False)
    for circle in circles:
        along = end - begin
        along[circle] = 0.0
        tried = np.repeat(middle[None], len(headings), axis=0)
        tried[:, circle] = headings
        possible = _forbidden(problem, tried, along, matters) <= GUESS.slip
        if possible.any():
            angles = tried[possible, circle]
            turns = np.abs(np.angle(np.exp(1j * (angles - before[circle]))))
            ends = [begin.copy(), end.copy()]
            for x in ends:
                x[circle] = angles[int(turns.argmin())]
            return ends
    return None


def _forbidden(problem: PlanningTask, x: Array, along: Array, matters: NDArray[np.int64]) -> Array:
    """Return the fraction of a motion that constraints forbid at states (m, nx), shape (m,)."""
    large = problem.scales[matters]
    wanted = along[matters] / large
    size = float(np.linalg.norm(wanted))
    if size == 0.0:
        return np.zeros(len(x))
    J = velocity_directions(problem, x, matters) / large[:, None]
    kept = J @ (np.linalg.pinv(J, rcond=GUESS.rank_tolerance) @ wanted[:, None])
    missed: Array = np.linalg.norm(wanted - kept[..., 0], axis=1) / size
    return missed
