"""Does the machine collide, with what, and how much room is left?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from kinolab.errors import UnknownNameError
from kinolab.world.clearance import fixtures, room
from kinolab.world.contact import TOUCH, body_object, make_touches, obstacle_object
from kinolab.world.geometry import Array, BodyGeometry
from kinolab.world.screen import (
    SLACK,
    enclose,
    grounded,
    inside,
    make_scene,
    near_surface,
    overlap,
    place,
    screen,
)
from kinolab.world.world import World

GROUND_NAME = "ground"


@dataclass(frozen=True)
class Contact:
    """One reason why a pose collides.

    ``obstacle`` is an obstacle's name, "ground", or another body's name; it is empty where the
    body's own pose is not finite. ``kind`` says how: the surfaces meet ("touches"), the body is
    wholly inside a solid mesh ("inside"), it rests on the ground but is pressed into it
    ("sinks"), or it could not be judged ("error").
    """

    body: str
    obstacle: str
    kind: Literal["touches", "inside", "sinks", "error"]


class CollisionChecker:
    """Judges poses of one machine in one world.

    A pose table holds one row [R | p] per body in the order of ``bodies``: (bodies, 12) or
    (bodies, 3, 4), world from body, in metres. A checker writes into its own scratch memory: give
    every thread its own.

    Args:
        bodies: What moves.
        world: What does not.
        margin: By how much to inflate the bodies, in [m]. A resting body is not inflated towards
            the ground. The corners of a box come to lie up to 1.7 margins outside.
        self_pairs: Names of bodies that may not touch each other.

    Raises:
        UnknownNameError: If ``self_pairs`` names a body that does not exist.
    """

    def __init__(
        self,
        bodies: Sequence[BodyGeometry],
        world: World,
        *,
        margin: float = 0.0,
        self_pairs: Sequence[tuple[str, str]] = (),
    ) -> None:
        self.bodies, self.world, self.margin = tuple(bodies), world, margin
        shapes = [shape for body in bodies for shape in body.shapes]
        own_pairs = _own_pairs(self.bodies, self_pairs)
        grow = TOUCH + margin
        self.scene, self.grid = make_scene(self.bodies, world, own_pairs, grow, margin)
        self._arrays = (*self.scene, *self.grid)
        self._fixtures = fixtures(world)
        self._touches = make_touches()
        self._movers = [body_object(shape, grow) for shape in shapes]
        self._obstacles = [obstacle_object(obstacle) for obstacle in world.obstacles]
        self._shape = (len(bodies), 12)
        self._allocate(len(shapes))

    def _allocate(self, shapes: int) -> None:
        most = shapes * len(self._obstacles) + len(self.scene.own_pairs)
        self._turns, self._places = np.zeros((shapes, 3, 3)), np.zeros((shapes, 3))
        self._around = np.zeros((shapes, 6))
        self._pairs = np.zeros((most + 1, 2), dtype=np.int64)
        self._scratch = (self._turns, self._places, self._around, self._pairs)
        # Views made once: FCL wants arrays, and slicing costs as much as setting.
        self._where = list(zip(self._movers, self._turns, self._places, strict=True))

    def collides(self, poses: Array) -> bool:
        """Say whether anything touches; what cannot be judged counts as touching."""
        left = screen(self._table(poses), *self._scratch, *self._arrays)
        if left <= 0:
            return bool(left < 0)
        try:
            return self._any_touch(self._pairs[:left].tolist())
        except Exception:  # whatever FCL raises, the pose was not found to be free
            return True

    def contacts(self, poses: Array) -> list[Contact]:
        """List everything that touches, each pair of body and obstacle once; empty if free."""
        table = self._table(poses)
        finite = [bool(np.isfinite(row).all()) for row in table]
        found = [
            Contact(body.name, "", "error")
            for body, sound in zip(self.bodies, finite, strict=True)
            if not sound
        ]
        sound_shapes = [s for s, body in enumerate(self.scene.body) if finite[body]]
        for shape in sound_shapes:
            self._place(shape, table)
            found += self._ground_contacts(shape)
            found += self._obstacle_contacts(shape)
        found += self._own_contacts(set(sound_shapes))
        return list(dict.fromkeys(found))

    def clearance(self, poses: Array) -> float:
        """Bound from below how far every point may move before anything can touch.

        This is the smallest distance to an obstacle or the ground, or half the distance between
        two bodies of a self pair, less the margin. It is within 1e-8 m of the true value and
        never above it. The ground does not count for bodies that rest on it.

        Returns:
            A distance in [m]; 0 when colliding, infinite where there is nothing to collide with.
        """
        if self.collides(poses):
            return 0.0
        scene, grid = self.scene, self.grid
        free = room(
            *(self._turns, self._places, self._around),
            *(scene.kind, scene.half, scene.rests, scene.obstacle, scene.own_pairs),
            *(scene.grow, scene.ground),
            *(*self._fixtures, grid.triangles, grid.boxes),
        )
        return max(float(free) - self.margin, 0.0)

    def _table(self, poses: Array) -> Array:
        if poses.shape == self._shape and poses.dtype == np.float64 and poses.flags.c_contiguous:
            return poses
        return np.ascontiguousarray(poses, dtype=np.float64).reshape(self._shape)

    def _any_touch(self, pairs: list[list[int]]) -> bool:
        """Ask FCL about pairs of a shape and an obstacle, or of two shapes."""
        touches, count, placed = self._touches, len(self._obstacles), -1
        for shape, other in pairs:
            if shape != placed:
                mover, placed = self._moved(shape), shape
            fixed = self._obstacles[other] if other < count else self._moved(other - count)
            if touches(mover, fixed):
                return True
        return False

    def _moved(self, shape: int) -> object:
        mover, turn, at = self._where[shape]
        mover.setRotation(turn)  # type: ignore[attr-defined]
        mover.setTranslation(at)  # type: ignore[attr-defined]
        return mover

    def _place(self, shape: int, table: Array) -> None:
        scene, turn, at = self.scene, self._turns[shape], self._places[shape]
        place(table[scene.body[shape]], scene.own[shape], turn, at)
        size = (scene.kind[shape], scene.half[shape])
        enclose(*size, turn, at, scene.grow + SLACK, self._around[shape])

    def _ground_contacts(self, shape: int) -> Iterator[Contact]:
        scene, rests = self.scene, self.scene.rests[shape]
        low = self._around[shape, 2] + scene.grow + SLACK
        if scene.ground and grounded(low, rests, scene.margin):
            yield Contact(self._name(shape), GROUND_NAME, "sinks" if rests else "touches")

    def _obstacle_contacts(self, shape: int) -> Iterator[Contact]:
        for k, obstacle in enumerate(self.world.obstacles):
            if overlap(self._around[shape], self.scene.obstacle[k]):
                kind = self._kind(shape, k)
                if kind is not None:
                    yield Contact(self._name(shape), obstacle.name, kind)

    def _kind(self, shape: int, k: int) -> Literal["touches", "inside", "error"] | None:
        mesh, grid = self.scene.mesh[k], self.grid
        index = (grid.frame, grid.extent, grid.start, grid.entries)
        try:
            near = mesh < 0 or near_surface(self._around[shape], mesh, grid.boxes, *index)
            if near and self._touches(self._moved(shape), self._obstacles[k]):
                return "touches"
        except Exception:  # as in ``collides``
            return "error"
        parts = (grid.triangles, grid.part, grid.volume)
        if mesh >= 0 and inside(self._places[shape], mesh, *parts, *index):
            return "inside"
        return None

    def _own_contacts(self, sound: set[int]) -> Iterator[Contact]:
        for a, b in self.scene.own_pairs.tolist():
            if {a, b} <= sound and overlap(self._around[a], self._around[b]):
                try:
                    if self._touches(self._moved(a), self._moved(b)):
                        yield Contact(self._name(a), self._name(b), "touches")
                except Exception:  # as in ``collides``
                    yield Contact(self._name(a), self._name(b), "error")

    def _name(self, shape: int) -> str:
        return str(self.bodies[self.scene.body[shape]].name)


def _own_pairs(
    bodies: Sequence[BodyGeometry], names: Sequence[tuple[str, str]]
) -> list[tuple[int, int]]:
    """Expand pairs of bodies into pairs of their shapes, numbered over all bodies."""
    shapes: dict[str, list[int]] = {body.name: [] for body in bodies}
    owners = [body.name for body in bodies for _ in body.shapes]
    for shape, owner in enumerate(owners):
        shapes[owner].append(shape)
    for name in (name for pair in names for name in pair if name not in shapes):
        raise UnknownNameError("body", name, known=shapes, where="self-collision pairs")
    return [(a, b) for one, other in names for a in shapes[one] for b in shapes[other]]
