"""Control points: points of bodies that the field attracts, with their goal positions.

Source: Barraquand, Latombe, Robot motion planning: a distributed representation approach,
IJRR 10(6), 1991.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.search.potential.leading_bodies import LeadingBody, leading_bodies, sample_states

POINT_TOLERANCE = 1e-6  # [m] spread of a point's positions that counts as none
RANDOM_STATES = 12


@dataclass(frozen=True, eq=False)
class ControlPoint:
    """A point of a body with a goal position.

    Attributes:
        carrier: The body that it belongs to.
        at: Position in the body frame, in [m], shape (3,).
        goal: Goal position in the world frame, in [m], shape (3,).
        name: For reports.
    """

    carrier: LeadingBody
    at: Array
    goal: Array
    name: str


def control_points(problem: PlanningTask) -> list[ControlPoint]:
    """Return the points whose goal position is determined; none if the goal determines no position.

    A slender body that is free to turn has one at each end, which also determine its attitude; any
    other has one at its centre or at the origin of its frame. Immovable points, such as pivots, are
    left out.
    """
    generator = np.random.default_rng(0)
    goals = np.array([problem.sample_goal(generator, spread=0.0) for _ in range(RANDOM_STATES)])
    goals = problem.model.project(goals)
    leaders = leading_bodies(problem)
    named = [_of_point(problem, leaders, k) for k in range(len(problem.goal.points))]
    frames = problem.frames(sample_states(problem, RANDOM_STATES))
    points = (p for c in leaders for p in _points_of(problem, c, goals))
    moved = (p for p in points if not _known(place(p.at, frames[:, p.carrier.body])))
    return [*named, *(p for p in moved if not any(_same(p, other) for other in named))]


def _same(a: ControlPoint, b: ControlPoint) -> bool:
    alike = bool(np.abs(a.at - b.at).max() < POINT_TOLERANCE)
    return a.carrier.body == b.carrier.body and alike


def place(at: Array, poses: Array) -> Array:
    """Transform a body point (3,) to the world, shape (n, 3), at the body's poses (n, 12)."""
    frame = poses.reshape(-1, 3, 4)
    where: Array = frame[:, :, :3] @ at + frame[:, :, 3]
    return where


def _of_point(problem: PlanningTask, leaders: list[LeadingBody], k: int) -> ControlPoint:
    target = problem.goal.points[k]
    owner = next((c for c in leaders if c.body == target.body), None)
    zero = np.zeros(3)
    carrier = owner or LeadingBody(target.body, (), zero, zero)
    name = f"{problem.bodies[target.body].name}"
    return ControlPoint(carrier, np.array(target.at), np.array(target.position), name)


def _points_of(problem: PlanningTask, carrier: LeadingBody, goals: Array) -> Iterator[ControlPoint]:
    poses = problem.frames(goals)[:, carrier.body]
    name = problem.bodies[carrier.body].name
    ends = _ends(problem, carrier)
    if all(_known(place(at, poses)) for at in ends.values()) and ends:
        for end, at in ends.items():
            yield ControlPoint(carrier, at, place(at, poses)[0], f"{end} of {name}")
        return
    for at in (carrier.centre, np.zeros(3)):
        # If the goal leaves the attitude free, the frame's origin may still be determined.
        if _known(place(at, poses)):
            yield ControlPoint(carrier, at, place(at, poses)[0], name)
            return


def _known(places: Array) -> bool:
    return bool(np.ptp(places, axis=0).max() < POINT_TOLERANCE)


def _ends(problem: PlanningTask, carrier: LeadingBody) -> dict[str, Array]:
    """Return the front and back of a slender body that is free to turn, in its frame, (3,) each."""
    along = int(carrier.reach.argmax())
    width = float(np.sort(carrier.reach)[1])
    # length over width from which a body has two control points
    if carrier.reach[along] < 1.2 * width:
        return {}
    axes = problem.frames(sample_states(problem, RANDOM_STATES))[:, carrier.body].reshape(-1, 3, 4)
    axes = axes[:, :, along]
    # [rad] range of its axis from which a body counts as free to turn
    if np.arccos(np.clip(axes @ axes.T, -1.0, 1.0)).max() < 1.0:
        return {}
    step = np.zeros(3)
    # A ball of the body's width fits around an end, unless that leaves no lever arm.
    step[along] = max(carrier.reach[along] - width, carrier.reach[along] / 2)
    return {"front": carrier.centre + step, "back": carrier.centre - step}
