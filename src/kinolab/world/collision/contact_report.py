"""Who touches whom at a pose, and how: what is told to users."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from kinolab.numerics.arrays import Array
from kinolab.numerics.struct import Record
from kinolab.world.collision.broadphase import (
    ROUNDING_MARGIN,
    CheckerArrays,
    clear_of_meshes,
    grounded,
    place,
)
from kinolab.world.collision.fcl import Narrowphase
from kinolab.world.collision.triangle_grid import inside, near_surface, overlap
from kinolab.world.placed_shapes import enclose

GROUND_NAME = "ground"
LARGE = 50_000  # triangles, for which FCL builds its search tree in 0.2 s
Kind: TypeAlias = Literal["touches", "inside", "sinks", "near", "error"]


@dataclass(frozen=True)
class Contact:
    """One reason why a pose collides.

    ``body`` is a body's or a cable's name. ``obstacle`` is an obstacle's name, "ground", or the
    name of another part of the machine; it is empty where the body's own pose is not finite.
    ``kind`` says how: the surfaces meet ("touches"), the body is wholly inside a solid mesh
    ("inside"), it rests on the ground but is pressed into it ("sinks"), it is closer than the
    world's clearance ("near"), or it could not be judged ("error").
    """

    body: str
    obstacle: str
    kind: Kind


class ContactReport:
    """Lists what touches among a machine's shapes.

    Args:
        owners: The body or cable of each shape.
        obstacles: Names of the world's obstacles.
        record: The machine in its world, ``CheckerArrays``, cables placed in its scratch.
        narrowphase: Judges pairs of what is placed there.
    """

    def __init__(
        self,
        owners: Sequence[str],
        obstacles: Sequence[str],
        record: Record,
        narrowphase: Narrowphase,
    ) -> None:
        self._owners, self._obstacles = owners, obstacles
        arrays: CheckerArrays = record.held
        self._record, self._arrays, self._narrowphase = record, arrays, narrowphase
        self._large = len(arrays.tree.triangles) > LARGE
        self._grid, self._scratch = Record(arrays.grid), arrays.scratch
        self._around = arrays.scratch.around

    def contacts(self, poses: Array, sound: Sequence[int]) -> Iterator[Contact]:
        """Yield the contacts at poses (bodies, 12) of the shapes whose places are finite."""
        for shape in sound:
            self._place(shape, poses)
            yield from self._with_ground(shape)
            yield from self._with_obstacles(shape)
        yield from self._with_each_other(set(sound))

    def _place(self, shape: int, poses: Array) -> None:
        scene, scratch = self._arrays.scene, self._scratch
        turn, at, body = scratch.turns[shape], scratch.places[shape], scene.body[shape]
        if body >= 0:
            place(poses[body], scene.own[shape], turn, at)
        size = (scene.kind[shape], scene.half[shape])
        enclose(*size, turn, at, scene.grow + ROUNDING_MARGIN, self._around[shape])

    def _with_ground(self, shape: int) -> Iterator[Contact]:
        scene, rests = self._arrays.scene, self._arrays.scene.rests[shape]
        low = self._around[shape, 2] + scene.grow + ROUNDING_MARGIN
        if scene.body[shape] >= 0 and scene.ground and grounded(low, rests, scene.margin):
            yield Contact(self._owners[shape], GROUND_NAME, "sinks" if rests else "touches")

    def _with_obstacles(self, shape: int) -> Iterator[Contact]:
        for k, name in enumerate(self._obstacles):
            if overlap(self._around[shape], self._arrays.scene.obstacle[k]):
                kind = self._kind(shape, k)
                if kind is not None:
                    yield Contact(self._owners[shape], name, kind)

    def _kind(self, shape: int, k: int) -> Kind | None:
        mesh, kind = self._arrays.scene.mesh[k], None
        if mesh < 0 or (
            near_surface(self._around[shape], mesh, self._grid) and not self._clear(shape)
        ):
            kind = self._judged(shape, k)
        if kind is None and mesh >= 0 and inside(self._scratch.places[shape], mesh, self._grid):
            return "inside"
        return kind

    def _clear(self, shape: int) -> bool:
        """Say whether a gap to large meshes is proved; of small ones FCL is asked."""
        return self._large and bool(clear_of_meshes(shape, self._record))

    def _with_each_other(self, sound: set[int]) -> Iterator[Contact]:
        for a, b in self._arrays.scene.own_pairs.tolist():
            if {a, b} <= sound and overlap(self._around[a], self._around[b]):
                kind = self._judged(a, len(self._obstacles) + b)
                if kind is not None:
                    yield Contact(self._owners[a], self._owners[b], kind)

    def _judged(self, shape: int, other: int) -> Kind | None:
        try:
            return "touches" if self._narrowphase.any_touch([(shape, other)]) else None
        except Exception:  # whatever FCL raises, the pose was not found to be free
            return "error"
