"""Where bodies come nearest to obstacles, by FCL: what pushes them apart.

FCL's distances can exceed the true ones by 2 mm (see ``separation``): enough to be pushed by, never
enough to call a way free. Facts, tried with python-fcl 0.7.0.11: of two primitives the points are
in the world, in the order asked; beside a mesh the mesh's point comes first whatever the order, in
the mesh's own frame (ours have none but the world's); between a ball and a mesh they are wrong, so
that a ball is asked as a capsule without length. Inside an overlap all numbers are garbage.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from kinolab.dynamics.facts.machine_facts import BodyGeometry
from kinolab.dynamics.language.shapes import Shape
from kinolab.numerics.arrays import Array
from kinolab.world.collision.fcl import (
    body_object,
    nearest_points,
    obstacle_object,
    overlapping,
    point_capsule,
    touch,
)
from kinolab.world.distances.placed_shapes import obstacle_arrays
from kinolab.world.obstacles.world import World
from kinolab.world.shapes.geometry import placement, sizes
from kinolab.world.shapes.support_functions import core_radius, core_support


@dataclass(frozen=True, eq=False)
class Gap:
    """The shortest way between a shape of a body and an obstacle.

    Attributes:
        body: Index of the body.
        distance: In [m]; 0 where they touch, and then the points mean nothing.
        on_body: The body's nearest point in the world, shape (3,), in [m].
        on_obstacle: The obstacle's.
    """

    body: int
    distance: float
    on_body: Array
    on_obstacle: Array


class GapFinder:
    """Lists the gaps between the bodies and a world that are shorter than a reach.

    Args:
        bodies: What moves.
        world: What does not. The ground pushes no body that may touch it.
        reach: In [m].
    """

    def __init__(self, bodies: Sequence[BodyGeometry], world: World, reach: float) -> None:
        self._reach = reach
        self._movers = [
            _Mover(k, shape, reach, world.ground and not body.touches_ground)
            for k, body in enumerate(bodies)
            for shape in body.shapes
        ]
        self._obstacles = [(obstacle_object(o), o.primitive is None) for o in world.obstacles]
        self._boxes = obstacle_arrays(world.obstacles).box
        self._near = np.empty(len(self._boxes), np.int64)

    def gaps(self, poses: Array) -> list[Gap]:
        """Return the gaps at poses (bodies, 12)."""
        found = []
        for mover in self._movers:
            mover.move(poses[mover.body].reshape(3, 4))
            if mover.over_ground:
                found.append(_over_ground(mover))
            count = overlapping(mover.box, self._boxes, self._near)
            for obstacle, is_mesh in (self._obstacles[k] for k in self._near[:count].tolist()):
                # Whether two things touch is known a hundred times sooner than how far they are.
                if touch(mover.swollen, obstacle):
                    found.append(_gap(mover, obstacle, is_mesh))
        return [gap for gap in found if gap.distance < self._reach]


class _Mover:
    """A shape of a body as FCL has it: as large as it is, and larger by the reach."""

    def __init__(self, body: int, shape: Shape, reach: float, over_ground: bool) -> None:
        kind, self.half = sizes(shape)
        self.body, self.kind, self.over_ground = body, int(kind), over_ground
        self._own = placement(shape)
        self.ball = shape.symmetric == "xyz"
        self.exact: Any = point_capsule(self.half[0]) if self.ball else body_object(shape, 0.0)
        self.swollen: Any = body_object(shape, reach)
        self.turn, self.at = np.eye(3), np.zeros(3)
        # no point is farther from the centre than a corner of the half sizes and a cap's radius
        self._around = float(np.linalg.norm(self.half[:3]) + self.half[0]) + reach
        self.box = np.zeros(6)

    def move(self, pose: Array) -> None:
        """Place it where a body's pose (3, 4) has it."""
        self.turn = pose[:, :3] @ self._own[:, :3]
        self.at = pose[:, :3] @ self._own[:, 3] + pose[:, 3]
        self.box[:3], self.box[3:] = self.at - self._around, self.at + self._around
        for thing in (self.exact, self.swollen):
            thing.setRotation(self.turn)
            thing.setTranslation(self.at)


def _gap(mover: _Mover, obstacle: object, is_mesh: bool) -> Gap:
    if touch(mover.exact, obstacle):
        return Gap(mover.body, 0.0, np.zeros(3), np.zeros(3))
    distance, first, second = nearest_points(mover.exact, obstacle)
    on_body, on_obstacle = (second, first) if is_mesh else (first, second)
    if mover.ball and distance > 0:
        # FCL's point on the ball is up to 0.2 mm off; the one on the obstacle tells the direction.
        away = on_obstacle - mover.at
        length = float(np.linalg.norm(away))
        on_body, distance = mover.at + mover.half[0] / length * away, length - mover.half[0]
    return Gap(mover.body, max(distance, 0.0), on_body, on_obstacle)


def _over_ground(mover: _Mover) -> Gap:
    """Return the gap to the plane z = 0, in closed form."""
    local = np.zeros(3)
    core_support(mover.kind, mover.half, -mover.turn[2], local)
    lowest = mover.turn @ local + mover.at
    lowest[2] -= core_radius(mover.kind, mover.half)
    return Gap(mover.body, max(float(lowest[2]), 0.0), lowest, lowest * [1.0, 1.0, 0.0])
