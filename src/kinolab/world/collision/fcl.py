"""FCL behind one door: does this shape touch that obstacle, and what pushes it away?

What decides about collision only ever asks FCL whether two things collide, never how far apart or
how deep they are: see ``separation``. Its answers have a tolerance, which ``CONTACT_MARGIN``
covers: of 1500 random contacts of a cylinder with a box, python-fcl 0.7.0.11 missed 1092 that
overlap by 1e-7 m, 11 at 1e-6 m, one at 5e-6 m and none at 1e-5 m; the other pairs do better. Its
second solver, GST_INDEP, misses overlaps of a millimetre and is not used.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import reduce
from typing import Any

import fcl
import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.facts.machine_facts import BodyGeometry, CableGeometry
from kinolab.dynamics.language.shapes import Shape, ShapeKind
from kinolab.dynamics.language.shapes.hulls import grown_hull, hull_surface
from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.world.collision.broadphase import Scratch
from kinolab.world.distances.triangle_grid import overlap
from kinolab.world.obstacles.kept_together import kept_together
from kinolab.world.obstacles.obstacle import Obstacle
from kinolab.world.shapes.geometry import frame_in_world, sizes
from kinolab.world.shapes.shape_surfaces import Faces

# [m] that bodies are inflated by, so that touching is a collision for every pair
CONTACT_MARGIN = 1e-5
TILE_SIZE = 5000  # triangles at most, whose search tree is built in 20 ms


def body_object(shape: Shape, grow: float) -> Any:
    """Make the FCL object of a body's shape, ``grow`` larger on every side, at the origin."""
    return fcl.CollisionObject(_geometry(shape, grow))


def obstacle_object(obstacle: Obstacle) -> object:
    """Make the FCL object of an obstacle, at its place."""
    if obstacle.primitive is None:
        return fcl.CollisionObject(_surface((obstacle,)))
    thing = fcl.CollisionObject(_geometry(obstacle.primitive[0], 0.0))
    turn, at = frame_in_world(*obstacle.primitive)
    thing.setRotation(turn)
    thing.setTranslation(at)
    return thing


def point_capsule(radius: float) -> object:
    """Make a ball of a capsule without length, whose points nearest to a mesh are right."""
    return fcl.CollisionObject(fcl.Capsule(radius, 0.0))


def touch(a: object, b: object) -> bool:
    """Say whether two objects touch."""
    return bool(fcl.collide(a, b, fcl.CollisionRequest(), fcl.CollisionResult()))


def nearest_points(a: object, b: object) -> tuple[float, Array, Array]:
    """Return the distance of two objects in [m], and their points, shape (3,), in FCL's order."""
    request, result = fcl.DistanceRequest(enable_nearest_points=True), fcl.DistanceResult()
    distance = float(fcl.distance(a, b, request, result))
    first, second = (np.array(point, dtype=float) for point in result.nearest_points)
    return distance, first, second


class Obstacles:
    """The FCL objects of a world's obstacles, each made when it is first asked for.

    The search tree of a large mesh takes a while, and most poses are far from most meshes.
    """

    def __init__(self, obstacles: Sequence[Obstacle]) -> None:
        self._obstacles = obstacles
        self._objects: list[object | None] = [None] * len(obstacles)
        self._large = [
            o.primitive is None and (o.ball > 0.0 or len(o.faces) > TILE_SIZE) for o in obstacles
        ]

    def __len__(self) -> int:
        return len(self._objects)

    def __getitem__(self, k: int) -> object:
        found = self._objects[k]
        if found is None:
            found = self._objects[k] = obstacle_object(self._obstacles[k])
        return found

    def near(self, k: int, box: Array) -> Iterable[object]:
        """Return the objects that a box (6,) may meet: tiles of a large mesh, balls of a cloud."""
        return _tiles((self._obstacles[k],)).near(box) if self._large[k] else (self[k],)

    def build(self) -> None:
        """Make all objects but the tiles of large meshes."""
        for k, large in enumerate(self._large):
            if not large:
                self[k]


class Narrowphase:
    """Judges pairs of placed shapes, and of shapes and obstacles.

    Args:
        bodies, cables: What moves; the shapes of the cables that collide come last.
        grow: By how much they are inflated, in [m].
        obstacles: What does not move.
        scratch: Where the shapes are, and the boxes around them.
        half: Half sizes in [m], those of cables as long as they are, shape (shapes, 3).
    """

    def __init__(
        self,
        bodies: Sequence[BodyGeometry],
        cables: Sequence[CableGeometry],
        grow: float,
        obstacles: Obstacles,
        scratch: Scratch,
        half: Array,
    ) -> None:
        solids = [body_object(shape, grow) for body in bodies for shape in body.shapes]
        self._capsules = [fcl.Capsule(c.radius + grow, 0.0) for c in cables if c.collides]
        movers = solids + [fcl.CollisionObject(capsule) for capsule in self._capsules]
        # Views made once: FCL wants arrays, and slicing costs as much as setting.
        self._where = list(zip(movers, scratch.turns, scratch.places, strict=True))
        self._obstacles, self._half, self._first_cable = obstacles, half, len(solids)
        self._around = scratch.around
        # One request and one result for all times.
        self._request = fcl.CollisionRequest(num_max_contacts=1)
        self._result = fcl.CollisionResult()

    def any_touch(self, pairs: Iterable[Sequence[int]]) -> bool:
        """Say whether any pair touches, as ``Scratch`` counts obstacles and shapes."""
        count, placed, collide = len(self._obstacles), -1, fcl.collide
        for shape, other in pairs:
            if shape != placed:
                mover, placed = self._moved(shape), shape
            if other < count:
                things = self._obstacles.near(other, self._around[shape])
            else:
                things = (self._moved(other - count),)
            for fixed in things:
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
    radius, (x, y, z) = half[0] + grow, 2.0 * (half[:3] + grow)
    made: dict[ShapeKind, Callable[[], object]] = {
        ShapeKind.BOX: lambda: fcl.Box(x, y, z),
        ShapeKind.SPHERE: lambda: fcl.Sphere(radius),
        ShapeKind.CYLINDER: lambda: fcl.Cylinder(radius, z),
        ShapeKind.CAPSULE: lambda: fcl.Capsule(radius, 2.0 * half[2]),
        ShapeKind.HULL: lambda: _hull(grown_hull(half[3:].reshape(-1, 3), grow)),
    }
    return made[kind]()


def _hull(corners: Array) -> object:
    vertices, faces, _ = hull_surface(corners)
    return fcl.Convex(vertices, len(faces), np.insert(faces, 0, 3, axis=1).ravel())


class FclTiles:
    """A mesh in tiles: the search tree of one is built when something first comes near to it.

    The tree of a million triangles takes seconds, and most motions pass a few thousand of them.

    Args:
        vertices: In [m], shape (n, 3).
        faces: Shape (m, 3).
        ball: In [m] around points, whose tiles have no search tree; 0 of a mesh.
    """

    def __init__(self, vertices: Array, faces: Faces, ball: float = 0.0) -> None:
        self._vertices, self._faces, self._ball = vertices, faces, ball
        corners = [vertices[faces[:, k]] for k in range(3)]
        low, high = (reduce(pick, corners) for pick in (np.minimum, np.maximum))
        self._rows = list(_divided(low + high, np.arange(len(faces))))
        tiles = [
            (low[rows].min(axis=0) - ball, high[rows].max(axis=0) + ball) for rows in self._rows
        ]
        self._boxes = np.array(tiles).reshape(-1, 6)
        self._objects: list[object | None] = [None] * len(self._rows)

    def near(self, box: Array) -> Iterator[object]:
        """Yield the objects that a box (6,), lowest and highest x, y, z in [m], may meet."""
        met = np.empty(len(self._boxes), np.int64)
        for k in met[: overlapping(box, self._boxes, met)].tolist():
            if self._ball > 0.0:
                yield from self._balls(k, box)
                continue
            found = self._objects[k]
            if found is None:
                used, faces = np.unique(self._faces[self._rows[k]], return_inverse=True)
                surface = _surface_model(self._vertices[used], faces.reshape(-1, 3))
                found = self._objects[k] = fcl.CollisionObject(surface)
            yield found

    def _balls(self, k: int, box: Array) -> Iterator[object]:
        """Yield the balls of a tile that a box may meet."""
        points = self._vertices[self._faces[self._rows[k], 0]]
        near = (points + self._ball >= box[:3]) & (points - self._ball <= box[3:])
        for point in points[near.all(axis=1)]:
            ball = fcl.CollisionObject(fcl.Sphere(self._ball))
            ball.setTranslation(point)
            yield ball


@kernel
def overlapping(box, boxes, found):  # type: ignore[no-untyped-def]
    """List the boxes that a box meets; return their number.

    Args:
        box: Lowest and highest x, y, z in [m], shape (6,).
        boxes: Likewise, shape (m, 6).
        found: Their rows, shape (m,); written.
    """
    count = 0
    for k in range(boxes.shape[0]):
        if overlap(box, boxes[k]):
            found[count] = k
            count += 1
    return count


def _surface_model(vertices: Array, faces: Faces) -> object:
    """Build FCL's search tree of triangles (m, 3) between vertices (n, 3) in [m]."""
    model = fcl.BVHModel()
    model.beginModel(len(faces), len(vertices))
    model.addSubModel(vertices, faces)
    model.endModel()
    return model


def _divided(middles: Array, rows: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    """Halve triangles with middles (m, 3) along their longest extent until tiles are small."""
    waiting = [rows]
    while waiting:
        rows = waiting.pop()
        if len(rows) <= TILE_SIZE:
            yield rows
            continue
        here, half = middles[rows], len(rows) // 2
        along = here[:, int(np.ptp(here, axis=0).argmax())]
        order = np.argpartition(along, half)
        waiting += [rows[order[:half]], rows[order[half:]]]


# Search trees, which only FCL reads: all checkers of a world share them.
_surface = kept_together(lambda one: _surface_model(*one[0].picture()))
_tiles = kept_together(lambda one: FclTiles(one[0].vertices, one[0].faces, one[0].ball))
