"""FCL behind one door: does this shape touch that obstacle?

What decides about collision only ever asks FCL whether two things collide, never how far apart or
how deep they are: see ``separation``. Its answers have a tolerance, which ``CONTACT_MARGIN``
covers: of 1500 random contacts of a cylinder with a box, python-fcl 0.7.0.11 missed 1092 that
overlap by 1e-7 m, 11 at 1e-6 m, one at 5e-6 m and none at 1e-5 m; the other pairs do better. Its
second solver, GST_INDEP, misses overlaps of a millimetre and is not used.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from weakref import WeakKeyDictionary

import fcl

from kinolab.dynamics.language.shapes import Shape
from kinolab.world.geometry import ShapeKind, placement, sizes
from kinolab.world.obstacle import Obstacle

# [m] that bodies are inflated by, so that touching is a collision for every pair
CONTACT_MARGIN = 1e-5


def cable_object(radius: float, grow: float) -> tuple[object, object]:
    """Make the FCL object of a cable, and its capsule, whose ``lz`` is the length to be set."""
    capsule = fcl.Capsule(radius + grow, 0.0)
    return fcl.CollisionObject(capsule), capsule


def body_object(shape: Shape, grow: float) -> object:
    """Make the FCL object of a body's shape, ``grow`` larger on every side, at the origin."""
    return fcl.CollisionObject(_geometry(shape, grow))


def obstacle_object(obstacle: Obstacle) -> object:
    """Make the FCL object of an obstacle, at its place."""
    if obstacle.primitive is None:
        return fcl.CollisionObject(_surface(obstacle))
    shape, pose = obstacle.primitive
    own = placement(shape)
    thing = fcl.CollisionObject(_geometry(shape, 0.0))
    thing.setRotation(pose[:, :3] @ own[:, :3])
    thing.setTranslation(pose[:, :3] @ own[:, 3] + pose[:, 3])
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


def make_touches() -> Callable[[object, object], bool]:
    """Make the question ``touches(a, b)`` with one request and result for all times."""
    request, collide = fcl.CollisionRequest(num_max_contacts=1), fcl.collide
    result = fcl.CollisionResult()

    def touches(a: object, b: object) -> bool:
        if collide(a, b, request, result):
            result.contacts.clear()
            return True
        return False

    return touches


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
