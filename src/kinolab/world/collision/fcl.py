"""FCL behind one door: does this shape touch that obstacle?

What decides about collision only ever asks FCL whether two things collide, never how far apart or
how deep they are: see ``separation``. Its answers have a tolerance, which ``CONTACT_MARGIN``
covers: of 1500 random contacts of a cylinder with a box, python-fcl 0.7.0.11 missed 1092 that
overlap by 1e-7 m, 11 at 1e-6 m, one at 5e-6 m and none at 1e-5 m; the other pairs do better. Its
second solver, GST_INDEP, misses overlaps of a millimetre and is not used.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any
from weakref import WeakKeyDictionary

import fcl

from kinolab.dynamics.language.shapes import Shape
from kinolab.numerics.arrays import Array
from kinolab.world.cable import CableGeometry
from kinolab.world.collision.broadphase import BroadphaseScratch
from kinolab.world.geometry import BodyGeometry, ShapeKind, frame_in_world, sizes
from kinolab.world.obstacle import Obstacle

# [m] that bodies are inflated by, so that touching is a collision for every pair
CONTACT_MARGIN = 1e-5


def body_object(shape: Shape, grow: float) -> Any:
    """Make the FCL object of a body's shape, ``grow`` larger on every side, at the origin."""
    return fcl.CollisionObject(_geometry(shape, grow))


def obstacle_object(obstacle: Obstacle) -> object:
    """Make the FCL object of an obstacle, at its place."""
    if obstacle.primitive is None:
        return fcl.CollisionObject(_surface(obstacle))
    thing = fcl.CollisionObject(_geometry(obstacle.primitive[0], 0.0))
    turn, at = frame_in_world(*obstacle.primitive)
    thing.setRotation(turn)
    thing.setTranslation(at)
    return thing


class Obstacles:
    """The FCL objects of a world's obstacles, each made when it is first asked for.

    The search tree of a large mesh takes a while, and most poses are far from most meshes.
    """

    def __init__(self, obstacles: Sequence[Obstacle]) -> None:
        self._obstacles = obstacles
        self._objects: list[object | None] = [None] * len(obstacles)

    def __len__(self) -> int:
        return len(self._objects)

    def __getitem__(self, k: int) -> object:
        found = self._objects[k]
        if found is None:
            found = self._objects[k] = obstacle_object(self._obstacles[k])
        return found


class Narrowphase:
    """Judges pairs of placed shapes, and of shapes and obstacles.

    Args:
        bodies, cables: What moves; the shapes of the cables that collide come last.
        grow: By how much they are inflated, in [m].
        obstacles: What does not move.
        scratch: Where the shapes are.
        half: Half sizes in [m], those of cables as long as they are, shape (shapes, 3).
    """

    def __init__(
        self,
        bodies: Sequence[BodyGeometry],
        cables: Sequence[CableGeometry],
        grow: float,
        obstacles: Obstacles,
        scratch: BroadphaseScratch,
        half: Array,
    ) -> None:
        solids = [body_object(shape, grow) for body in bodies for shape in body.shapes]
        self._capsules = [fcl.Capsule(c.radius + grow, 0.0) for c in cables if c.collides]
        movers = solids + [fcl.CollisionObject(capsule) for capsule in self._capsules]
        # Views made once: FCL wants arrays, and slicing costs as much as setting.
        self._where = list(zip(movers, scratch.turns, scratch.places, strict=True))
        self._obstacles, self._half, self._first_cable = obstacles, half, len(solids)
        # One request and one result for all times.
        self._request, self._result = (
            fcl.CollisionRequest(num_max_contacts=1),
            fcl.CollisionResult(),
        )

    def any_touch(self, pairs: Iterable[Sequence[int]]) -> bool:
        """Say whether any pair touches, as ``BroadphaseScratch`` counts obstacles and shapes."""
        count, placed, collide = len(self._obstacles), -1, fcl.collide
        for shape, other in pairs:
            if shape != placed:
                mover, placed = self._moved(shape), shape
            fixed = self._obstacles[other] if other < count else self._moved(other - count)
            if collide(mover, fixed, self._request, self._result):
                self._result.contacts.clear()
                return True
        return False

    def _moved(self, shape: int) -> object:
        mover, turn, at = self._where[shape]
        if shape >= self._first_cable:
            self._capsules[shape - self._first_cable].lz = 2.0 * self._half[shape, 2]
        mover.setRotation(turn)
        mover.setTranslation(at)
        return mover


def _geometry(shape: Shape, grow: float) -> object:
    """Make the FCL shape; FCL's cylinders and capsules lie along z like our own frames."""
    kind, half = sizes(shape)
    wide = 2.0 * (half + grow)
    if kind is ShapeKind.BOX:
        return fcl.Box(*wide)
    if kind is ShapeKind.SPHERE:
        return fcl.Sphere(half[0] + grow)
    if kind is ShapeKind.CAPSULE:
        return fcl.Capsule(half[0] + grow, 2.0 * half[2])
    return fcl.Cylinder(half[0] + grow, wide[2])


# Search trees, which only FCL reads: all checkers of a world share them.
_surfaces: WeakKeyDictionary[Obstacle, object] = WeakKeyDictionary()


def _surface(obstacle: Obstacle) -> object:
    model = _surfaces.get(obstacle)
    if model is None:
        model = fcl.BVHModel()
        model.beginModel(len(obstacle.faces), len(obstacle.vertices))
        model.addSubModel(obstacle.vertices, obstacle.faces)
        model.endModel()
        _surfaces[obstacle] = model
    return model
