"""The potential field of a machine: attraction of control points, repulsion from obstacles."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.search.potential.control_points import ControlPoint, place
from kinolab.world.collision.closest_points import Gap, GapFinder

MIN_DISTANCE = 1e-4  # [m] below which the repulsion is constant, so that it stays finite


@dataclass(frozen=True)
class Repulsion:
    """Repulsive potential gain / 2 (1/d - 1/reach)^2 at distance d, and 0 beyond the reach.

    Attributes:
        gain: In [m^3], so that the potential is in [m].
        reach: Range of influence in [m].
    """

    gain: float
    reach: float

    def potential(self, distance: float) -> float:
        """Return the potential in [m] at a distance in [m]; infinite at contact."""
        if distance <= 0:
            return math.inf
        if distance >= self.reach:
            return 0.0
        return 0.5 * self.gain * (1 / max(distance, MIN_DISTANCE) - 1 / self.reach) ** 2

    def force(self, gap: Gap) -> Array:
        """Return the force on the body at its closest point, away from the obstacle, shape (3,).

        Its norm is gain (1/d - 1/reach) / d^2, and 0 at contact, where no direction is defined.
        """
        d = max(gap.distance, MIN_DISTANCE)
        if not 0 < gap.distance < self.reach:
            return np.zeros(3)
        away = (gap.on_body - gap.on_obstacle) / gap.distance
        push: Array = self.gain * (1 / d - 1 / self.reach) / d**2 * away
        return push


PointPotential: TypeAlias = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class AttractivePotential:
    """A control point with its potential and weight."""

    point: ControlPoint
    potential: PointPotential
    weight: float


@dataclass(frozen=True, eq=False)
class PointForce:
    """A force on a point of a body: the negative gradient of the potential, dimensionless.

    Attributes:
        body: Index of the body.
        at: World point in [m], shape (3,).
        force: World vector, shape (3,).
    """

    body: int
    at: Array
    force: Array


class Field:
    """The sum of all potentials, in [m], as a function of the state.

    Args:
        pulls: Attractive potentials; without any, the norm of the goal errors.
    """

    def __init__(
        self, problem: PlanningTask, pulls: Sequence[AttractivePotential], repulsion: Repulsion
    ) -> None:
        self.problem, self.pulls, self.repulsion = problem, tuple(pulls), repulsion
        self._gaps = GapFinder(problem.bodies, problem.world, repulsion.reach)
        self._near = problem.checker(margin=repulsion.reach) if repulsion.gain > 0 else None

    def potential(self, states: Array) -> Array:
        """Return the potential at states (n, nx), shape (n,); infinite in collision."""
        poses = self.problem.frames(states)
        return self.attraction(states, poses) + [
            self._repelled(x, p) for x, p in zip(states, poses, strict=True)
        ]

    def attraction(self, states: Array, poses: Array) -> Array:
        """Return the attraction at states (n, nx) with poses (n, bodies, 12), shape (n,)."""
        if not self.pulls:
            return np.array([self.problem.goal_distance(x) for x in states])
        total = np.zeros(len(states))
        for pull in self.pulls:
            at = place(pull.point.at, poses[:, pull.point.carrier.body])
            total += pull.weight * pull.potential(at)[0]
        return total

    def points(self, states: Array) -> Array:
        """Return the control points' positions at states (n, nx), shape (n, points, 3)."""
        poses = self.problem.frames(states)
        found = [place(p.point.at, poses[:, p.point.carrier.body]) for p in self.pulls]
        return np.stack(found, axis=1) if found else np.zeros((len(states), 0, 3))

    def forces(self, x: Array) -> list[PointForce]:
        """Return the forces at a state (nx,), attractive ones first, then repulsive ones."""
        poses = self.problem.frames(x)
        found = []
        for pull in self.pulls:
            body = pull.point.carrier.body
            at = place(pull.point.at, poses[body][None])
            slope = pull.potential(at)[1][0]
            found.append(PointForce(body, at[0], -pull.weight * slope))
        if self._is_near(x, poses):
            for gap in self._gaps.gaps(poses):
                found.append(PointForce(gap.body, gap.on_body, self.repulsion.force(gap)))
        return found

    def pushed(self, x: Array, direction: Array) -> list[PointForce]:
        """Return equal forces, a vector (3,), on all control points at a state (nx,)."""
        poses = self.problem.frames(x)
        bodies = [(pull.point.carrier.body, pull.point.at) for pull in self.pulls]
        return [PointForce(b, place(at, poses[b][None])[0], direction) for b, at in bodies]

    def _repelled(self, x: Array, poses: Array) -> float:
        if not self._is_near(x, poses):
            return 0.0
        gaps = self._gaps.gaps(poses)
        return sum(self.repulsion.potential(gap.distance) for gap in gaps)

    def _is_near(self, x: Array, poses: Array) -> bool:
        """Say whether anything may be within reach; much faster than computing distances."""
        if self._near is None:
            return False
        ends = self.problem.placement(x)[1] if self.problem.cables else np.zeros((0, 6))
        return self._near.collides(poses, ends)


@dataclass(frozen=True, eq=False)
class StraightLinePotential:
    """Distance to a goal, smoothed near it: conic potential with a parabolic well.

    Attributes:
        goal: World point in [m], shape (3,).
        rounding: Distance in [m] below which it is parabolic.

    Source: Latombe, Robot Motion Planning, 1991, section 7.1.
    """

    goal: Array
    rounding: float = 0.1

    def __call__(self, points: Array) -> tuple[Array, Array]:
        """Return values (n,) in [m] and gradients (n, 3) at points (n, 3)."""
        away = points - self.goal
        distance = np.linalg.norm(away, axis=1)
        near = distance < self.rounding
        value = np.where(near, distance**2 / (2 * self.rounding), distance - self.rounding / 2)
        return value, away / np.maximum(distance, self.rounding)[:, None]
