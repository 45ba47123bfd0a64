"""Paths turned so that a machine may follow them: wheels that do not slip, a nose that leads."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.rotations import multiply
from kinolab.problem import PlanningTask
from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.trajopt.multistart.allowed_velocities import velocities_along, velocity_directions
from kinolab.trajopt.nlp.options import GUESS


def turned_along(problem: PlanningTask, path: Array) -> Array:
    """Return a path on which a heading follows the legs that constraints would forbid otherwise.

    For each leg, every angle on the circle is tried as the heading: the others' velocities must lie
    in the span of what the constraints allow. Of several headings, such as forward and backward,
    the nearest to the one before is taken.

    Args:
        path: Shape (m, nx).

    Returns:
        The same path where no angle makes a leg possible; else with a turn on the spot before it.

    Source: Laumond (ed.), Robot Motion Planning and Control, 1998, chapter 1 (the paths that a
    robot on two driven wheels follows).
    """
    nq = problem.model.nq
    matters = np.flatnonzero(~cyclic_coordinates(problem)[:nq])
    circles = [int(i) for i in np.flatnonzero(problem.circular[:nq]) if i in matters]
    model = problem.model
    rates = model.f(path[0], model.null_control()) if model.nq == model.nx else np.zeros(1)
    if not circles or np.abs(rates).max(initial=0.0) != 0.0:
        return path  # it would have to turn on the spot, and cannot do without velocities
    made, turned = [path[0]], False
    for begin, end in pairwise(path):
        leg = _turned(problem, begin, end, made[-1], circles, matters)
        made += [end] if leg is None else leg
        turned |= leg is not None
    if not turned:
        return path  # with its whole turns
    return problem.space.continuous(np.stack([*made, path[-1]]))


def turned_for_requirements(
    problem: PlanningTask, path: Array, quickest: Callable[[Array], float]
) -> Array:
    """Return a path on whose legs an attitude is turned about the vertical as requirements wish.

    For each leg that breaks a requirement at full speed, as many headings as there are in a circle
    are tried; of those that break the least, the nearest to the one before is taken.

    Args:
        path: Shape (m, nx).
        quickest: Returns the least time in [s] of a path.

    Returns:
        The same path where nothing is broken, or nothing can be turned.
    """
    attitudes = problem.space.rotations
    if not (problem.machine.requirements and len(attitudes) == 1) or problem.machine.modes:
        return path
    own = attitudes[0].own
    yaw = np.linspace(-np.pi, np.pi, GUESS.attitudes, endpoint=False)
    turns = np.stack([0 * yaw, 0 * yaw, np.sin(yaw / 2), np.cos(yaw / 2)], axis=1)
    headings = np.stack([multiply(turn, path[0, own]) for turn in turns])
    made, before, turned = [path[0]], path[0, own], False
    for begin, end in pairwise(path):
        tried = np.repeat(((begin + end) / 2)[None], 1 + len(headings), axis=0)
        tried[:, own] = np.vstack([before, headings])
        broken = _broken(problem, tried, end - begin, quickest(np.stack([begin, end])), own)
        if broken[0] > 0.0:
            best = np.flatnonzero(broken <= broken.min() + 1e-9)
            before, turned = tried[best[np.abs(tried[best][:, own] @ before).argmax()], own], True
        made += [begin.copy(), end.copy()]
        made[-2][own] = made[-1][own] = before
    return problem.space.continuous(np.stack([*made, path[-1]])) if turned else path


def _broken(problem: PlanningTask, x: Array, along: Array, seconds: float, own: slice) -> Array:
    """Return by how much requirements are broken on a leg at states (m, nx), shape (m,)."""
    nq = problem.model.nq
    matters = np.setdiff1d(np.arange(nq), np.arange(nq)[own])
    moving = x.copy()
    moving[:, nq:] = velocities_along(problem, x, along[matters] / max(seconds, 1e-9), matters)
    idle = np.clip(problem.model.control_bounds, -1e3, 1e3).mean(axis=1)
    margins = problem.model.requirements(moving, np.tile(idle, (len(x), 1)))
    missing: Array = np.maximum(-margins, 0.0).sum(axis=1)
    return missing


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
    trains = [circles] if len(circles) > 1 else []  # a trailer follows in line
    for turned in [*([circle] for circle in circles), *trains]:
        along = end - begin
        along[turned] = 0.0
        tried = np.repeat(middle[None], len(headings), axis=0)
        tried[:, turned] = headings[:, None]
        possible = _forbidden(problem, tried, along, matters) <= GUESS.slip
        if possible.any():
            angles = headings[possible]
            turns = np.abs(np.angle(np.exp(1j * (angles - before[turned[0]]))))
            ends = [begin.copy(), end.copy()]
            for x in ends:
                x[turned] = angles[int(turns.argmin())]
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
