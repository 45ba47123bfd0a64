"""Does the machine collide, and how much clearance is left?"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import replace

import numpy as np

from kinolab.dynamics.facts.machine_facts import BodyGeometry, CableGeometry
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array, allocate
from kinolab.numerics.struct import Record
from kinolab.world.collision.broadphase import (
    CheckerArrays,
    Scratch,
    broadphase,
    broadphase_rows,
    clearance_rows,
    make_broadphase,
    shape_owners,
)
from kinolab.world.collision.clearance import clearance_at
from kinolab.world.collision.contact_report import Contact, contacts_at
from kinolab.world.collision.fcl import CONTACT_MARGIN, Narrowphase, Obstacles
from kinolab.world.distances.placed_shapes import obstacle_arrays
from kinolab.world.distances.triangle_tree import mesh_tree
from kinolab.world.obstacles.world import World
from kinolab.world.shapes.cable import NO_ENDS, span_all
from kinolab.world.shapes.geometry import sizes, sizes_of
from kinolab.world.shapes.shrinking import shrunk_body, shrunk_cable


class CollisionChecker:
    """Judges poses of one machine in one world.

    A pose table holds one row [R | p] per body in the order of ``bodies``: (bodies, 12) or
    (bodies, 3, 4), world from body, in metres. A table of ends holds both ends of each cable in
    the world in metres: (cables, 6) or (cables, 2, 3). A machine without cables needs none. A
    checker writes into its own scratch memory: give every thread its own.

    Args:
        bodies: What moves.
        world: What does not. Less than its clearance beside an obstacle is a collision too.
        cables: What is stretched between moving points. The ground lets it pass.
        margin: By how much to inflate bodies and cables, in [m]. A resting body is not inflated
            towards the ground. The corners of a box come to lie up to 1.7 margins outside.
        self_pairs: Names of bodies or cables that may not touch each other.

    Raises:
        UnknownNameError: If ``self_pairs`` names a body or cable that does not exist.
    """

    def __init__(
        self,
        bodies: Sequence[BodyGeometry],
        world: World,
        *,
        cables: Sequence[CableGeometry] = (),
        margin: float = 0.0,
        self_pairs: Sequence[tuple[str, str]] = (),
    ) -> None:
        self.bodies, self.cables = tuple(bodies), tuple(cables)
        self.world, self._self_pairs = world, tuple(self_pairs)
        self._owners = shape_owners(bodies, cables)
        scene, self.grid = make_broadphase(bodies, cables, world, self_pairs)
        self.scene = scene._replace(kept=np.zeros(len(scene.own_pairs)))  # see ``_Beside``
        self._fixed, self._tree = obstacle_arrays(world.obstacles), mesh_tree(world.obstacles)
        self._shape, self._ends_shape = (len(bodies), 12), (len(cables), 6)
        self._rows = np.flatnonzero([cable.collides for cable in cables])
        self._obstacles = Obstacles(world.obstacles)
        self._beside: _Beside | None = None
        if world.clearance > 0:
            names = {body.name for body in bodies if body.prescribed}
            moving = [pair for pair in self_pairs if names.intersection(pair)]
            fixed = World(world.obstacles)
            alone = CollisionChecker(bodies, fixed, cables=cables, self_pairs=moving)
            self._beside = _Beside(alone, world.clearance)
        self._inflate(margin, world.ground)

    def inflated(self, margin: float, *, ground: bool) -> CollisionChecker:
        """Return a checker with another margin in [m], with or without the ground.

        It shares the obstacles with this one, not the scratch memory.
        """
        twin = copy(self)
        twin._beside = self._beside and self._beside.inflated(margin)
        twin._inflate(margin, ground)
        return twin

    def slimmer(self, by: float) -> CollisionChecker:
        """Return a checker of bodies and cables slimmer by a length in [m] on every side.

        It shares the obstacles with this one, not the scratch memory, and asks for no clearance.
        """
        twin = copy(self)
        twin._beside = None
        twin.bodies = tuple(shrunk_body(body, by) for body in self.bodies)
        twin.cables = tuple(shrunk_cable(cable, by) for cable in self.cables)
        slim = [sizes(shape)[1] for body in twin.bodies for shape in body.shapes]
        slim += [np.array([c.radius, c.radius, 0.0]) for c in twin.cables if c.collides]
        twin.scene = self.scene._replace(half=sizes_of(slim))
        twin._inflate(self.margin, self.scene.ground)
        return twin

    def thorough(self) -> CollisionChecker:
        """Return a checker that asks FCL about meshes also where a gap is proved.

        It shares the obstacles with this one, not the scratch memory.
        """
        twin = copy(self)
        twin.scene = self.scene._replace(sure=math.inf)
        return twin.inflated(self.margin, ground=self.scene.ground)

    def keeping(self, distance: float) -> CollisionChecker:
        """Return a checker whose clearance between two bodies is what exceeds a distance in [m].

        It shares the obstacles with this one, not the scratch memory.
        """
        twin = copy(self)
        twin.scene = self.scene._replace(kept=np.full(len(self.scene.own_pairs), distance))
        twin._inflate(self.margin, self.scene.ground)
        return twin

    def without_pairs(self) -> CollisionChecker:
        """Return a checker of obstacles and ground alone, not of bodies among themselves.

        It shares the obstacles with this one, not the scratch memory.
        """
        twin, scene = copy(self), self.scene
        twin.scene = scene._replace(own_pairs=scene.own_pairs[:0], kept=scene.kept[:0])
        twin._beside = self._beside and self._beside.without_pairs()
        twin._inflate(self.margin, scene.ground)
        return twin

    def of_pairs(self) -> CollisionChecker:
        """Return a checker of bodies and cables among themselves, and of obstacles that move."""
        alone = World(clearance=self.world.clearance)
        pairs = self._self_pairs
        return CollisionChecker(
            self.bodies, alone, cables=self.cables, margin=self.margin, self_pairs=pairs
        )

    def build(self) -> None:
        """Build the search trees of meshes, which would be built when they are first needed."""
        self._obstacles.build()

    def _inflate(self, margin: float, ground: bool) -> None:
        grow, self.margin = CONTACT_MARGIN + margin, margin
        half = self.scene.half.copy()  # the lengths of cables are written into it
        self.scene = self.scene._replace(grow=grow, margin=margin, ground=ground, half=half)
        shapes, obstacles = len(self._owners), self._obstacles
        most = shapes * len(obstacles) + len(self.scene.own_pairs)
        self._scratch = allocate(Scratch, {"shapes": shapes, "pairs": most + 1})
        self._arrays = Record(
            CheckerArrays(self._scratch, self.scene, self.grid, self._fixed, self._tree)
        )
        parts = (self.bodies, self.cables, grow)
        self._narrowphase = Narrowphase(*parts, obstacles, self._scratch, half)

    def collides(self, poses: Array, ends: Array = NO_ENDS) -> bool:
        """Say whether anything touches; what cannot be judged counts as touching."""
        if self._touching(poses, ends):
            return True
        return self._beside is not None and self._beside.near(poses, ends)

    def _touching(self, poses: Array, ends: Array) -> bool:
        if len(self._rows) and not self._span(ends):
            return True
        left = broadphase(self._table(poses), self._arrays)
        return bool(left < 0) if left <= 0 else self._asked(left)

    def _asked(self, left: int) -> bool:
        """Ask FCL about the first pairs that the screen has left."""
        try:
            return self._narrowphase.any_touch(self._scratch.pairs[:left].tolist())
        except Exception:  # whatever FCL raises, the pose was not found to be free
            return True

    def first_collision(self, poses: Array, ends: Array | None = None) -> int | None:
        """Return which of several poses is the first that collides, as ``collides`` judges each.

        Args:
            poses: A pose table each, shape (poses, bodies, 12) or (poses, bodies, 3, 4).
            ends: A table of ends each, shape (poses, cables, 6) or (poses, cables, 2, 3).

        Returns:
            The number of the pose; None where all are free.
        """
        table, strung = self._tables(poses, ends)
        k = 0
        while k < len(table):
            k, left = broadphase_rows(k, table, strung, self._rows, self._arrays)
            if k < len(table) and (left < 0 or self._asked(left)):
                break
            k += 1
        if self._beside is not None:
            k = self._beside.first(table[:k], strung[:k])
        return int(k) if k < len(table) else None

    def contacts(self, poses: Array, ends: Array = NO_ENDS) -> list[Contact]:
        """List everything that touches, each pair of body and obstacle once; empty if free."""
        whole = self._finite(poses, ends)
        found = [Contact(name, "", "error") for name, sound in whole.items() if not sound]
        self._span(ends)
        sound_shapes = [s for s, name in enumerate(self._owners) if whole[name]]
        names = [obstacle.name for obstacle in self.world.obstacles]
        parts = (self._owners, names, self._arrays, self._narrowphase)
        found += contacts_at(self._table(poses), sound_shapes, *parts)
        if not found and self._beside is not None:
            found += self._beside.contacts(poses, ends)
        return list(dict.fromkeys(found))

    def clearance(self, poses: Array, ends: Array = NO_ENDS, most: float = math.inf) -> float:
        """Return the clearance at one pose, as ``clearances`` does."""
        return float(self.clearances(self._table(poses)[None], self._ends(ends)[None], most)[0])

    def clearances(self, poses: Array, ends: Array | None = None, most: float = math.inf) -> Array:
        """Bound from below how far every point may move before anything can touch.

        This is the smallest distance to an obstacle or the ground, or half the distance between
        the two of a self pair, less the margin. It is within 1e-8 m of the true value (of a
        cable longer than 1 m, within 1e-8 of its length) and never above it. The ground counts
        neither for bodies that rest on it nor for cables.

        Args:
            poses: A pose table each, as ``first_collision`` takes them.
            ends: A table of ends each.
            most: More clearance than this in [m] is of no interest, and costs less to tell.

        Returns:
            Distances in [m], shape (poses,); 0 when colliding, ``most`` where there is nothing to
            collide with.
        """
        table, strung = self._tables(poses, ends)
        free, k, wanted = np.zeros(len(table)), 0, most + self.margin
        while k < len(table):
            k, left = clearance_rows(k, table, strung, self._rows, self._arrays, wanted, free)
            if k < len(table):
                free[k] = 0.0 if self._asked(left) else clearance_at(self._arrays, wanted)
            k += 1
        free -= self.margin
        if self._beside is not None:
            free = np.minimum(free, self._beside.clearances(table, strung, most))
        return np.maximum(free, 0.0)

    def _tables(self, poses: Array, ends: Array | None) -> tuple[Array, Array]:
        """Return poses and ends of several poses, (poses, bodies, 12) and (poses, cables, 6)."""
        table = np.ascontiguousarray(poses, dtype=np.float64)
        table = table.reshape(len(table), *self._shape)
        strung = np.zeros((len(table), 0)) if ends is None else ends
        if strung.size != 6 * len(self.cables) * len(table):
            raise _wrong_ends(len(self.cables), len(table), strung.size)
        strung = np.ascontiguousarray(strung, dtype=np.float64)
        return table, strung.reshape(len(table), *self._ends_shape)

    def _table(self, poses: Array) -> Array:
        return _contiguous(poses, self._shape)

    def _ends(self, ends: Array) -> Array:
        if ends.size != 6 * len(self.cables):
            raise _wrong_ends(len(self.cables), 1, ends.size)
        return _contiguous(ends, self._ends_shape)

    def _span(self, ends: Array) -> bool:
        """Stretch the capsules between their ends; False where an end is not finite."""
        table, half = self._ends(ends), self.scene.half
        return bool(span_all(table, self._rows, half, self._scratch.turns, self._scratch.places))

    def _finite(self, poses: Array, ends: Array) -> dict[str, bool]:
        """Say by name which bodies and which cables that collide have a place."""
        found = zip(self.bodies, np.isfinite(self._table(poses)), strict=True)
        strung = zip(self.cables, np.isfinite(self._ends(ends)), strict=True)
        sound = {body.name: bool(entries.all()) for body, entries in found}
        return sound | {c.name: bool(entries.all()) for c, entries in strung if c.collides}


class _Beside:
    """The clearance that the world asks for beside obstacles.

    Args:
        clearance: Of the world, in [m].
        margin: What is asked for in addition, in [m].
    """

    def __init__(self, alone: CollisionChecker, clearance: float, margin: float = 0.0) -> None:
        self._clearance, self._keep = clearance, clearance + margin
        # Between two that move it is half of what is left beyond the clearance.
        self._alone = alone.keeping(-clearance)
        self._wide = alone.inflated(self._keep, ground=False)  # by more, at corners of boxes

    def inflated(self, margin: float) -> _Beside:
        """Return the same with another margin in [m], with scratch memory of its own."""
        return _Beside(self._alone.inflated(0.0, ground=False), self._clearance, margin)

    def without_pairs(self) -> _Beside:
        """Return the same of the obstacles that stand."""
        twin = copy(self)
        twin._alone, twin._wide = self._alone.without_pairs(), self._wide.without_pairs()
        return twin

    def clearances(self, poses: Array, ends: Array, most: float) -> Array:
        """Return how far every point may move before too little is left, in [m]; 0 or less now."""
        return self._alone.clearances(poses, ends, most + self._keep) - self._keep

    def near(self, poses: Array, ends: Array) -> bool:
        """Say whether too little is left."""
        return (
            self._wide.collides(poses, ends) and not self._alone.clearance(poses, ends) > self._keep
        )

    def first(self, poses: Array, ends: Array) -> int:
        """Return the first pose at which too little is left, their number where there is none."""
        k = 0
        while k < len(poses):
            found = self._wide.first_collision(poses[k:], ends[k:])
            k = len(poses) if found is None else k + found
            if k < len(poses) and self.near(poses[k], ends[k]):
                break
            k += 1
        return min(k, len(poses))

    def contacts(self, poses: Array, ends: Array) -> list[Contact]:
        """Name what is too near."""
        if not self.near(poses, ends):
            return []
        return [replace(contact, kind="near") for contact in self._wide.contacts(poses, ends)]


def _contiguous(table: Array, shape: tuple[int, int]) -> Array:
    """Return a table (n, k) as compiled code takes it; most are so already."""
    if table.shape == shape and table.dtype == np.float64 and table.flags.c_contiguous:
        return table
    return np.ascontiguousarray(table, dtype=np.float64).reshape(shape)


def _wrong_ends(cables: int, poses: int, numbers: int) -> InputError:
    each = "" if poses == 1 else f" in each of {poses} poses"
    what = f"the ends of {cables} cables are needed{each}, not {numbers} numbers."
    return InputError([Mistake("cables", what, "Give model.cables(x) after the poses.")])
