"""Certified clearance: how far every point of a machine may move before anything can touch.

Cheap bounds come first: balls that contain the bodies, in a grid of distances. Where these are not
enough, the distance to what is near is worked out exactly. No answer is ever too large, and none is
below the true room by more than ``TOUCHING_MARGIN`` where that is smaller than what was asked for.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from threading import Lock
from typing import NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.numerics.struct import Record
from kinolab.world.cable import CableGeometry, finite, span
from kinolab.world.collision.broadphase import (
    MAX_PENETRATION,
    BroadphaseScene,
    enclose,
    make_broadphase,
    place,
)
from kinolab.world.collision.clearance import ObstacleArrays, obstacle_arrays
from kinolab.world.collision.distance_field import DistanceField, digest, distance_bound
from kinolab.world.collision.distance_field_cache import cached_distance_field
from kinolab.world.collision.gjk import TRIANGLE, Convex, box_gap, separation_within
from kinolab.world.collision.sphere_tree import SphereTree, sphere_tree
from kinolab.world.collision.triangle_grid import Integers, MeshGrid, inside
from kinolab.world.collision.triangle_tree import TriangleTree, triangle_tree
from kinolab.world.geometry import BodyGeometry
from kinolab.world.support_functions import half_extent, reach_along
from kinolab.world.world import World

TOUCHING_MARGIN = 3e-5  # [m] that is kept beside obstacles: FCL calls gaps of up to 1.7e-5 touching
SEARCH_FACTOR = 2.0  # times ``fine``: how far away what is near is looked for
STACK_SIZE = 64  # balls that wait at most, at a tree's depth
MAX_SUBDIVISIONS = 3  # balls that are divided
CABLE_SPHERES = 16  # balls along a cable
CELL_FRACTION = 0.25  # of a body's smallest half size, as which cells need not be finer


_one_at_a_time = Lock()


class Scratch(NamedTuple):
    """Memory to work in: one for every thread."""

    turns: Array  # (shapes, 3, 3) of placed shapes
    places: Array  # (shapes, 3)
    around: Array  # (shapes, 6) boxes of placed shapes
    queue: Integers  # (DEEPEST,)
    gaps: Array  # (DEEPEST,)
    corners: Array  # (3, 3) of a triangle
    simplex: Array  # (9, 3)


def scratch_for(scene: CollisionScene) -> Scratch:
    """Return memory to work in."""
    shapes = len(scene.broadphase.kind)
    return Scratch(
        turns=np.zeros((shapes, 3, 3)),
        places=np.zeros((shapes, 3)),
        around=np.zeros((shapes, 6)),
        queue=np.zeros(STACK_SIZE, np.int64),
        gaps=np.zeros(STACK_SIZE),
        corners=np.zeros((3, 3)),
        simplex=np.zeros((9, 3)),
    )


class CollisionScene(NamedTuple):
    """A machine's shapes and a world in flat arrays, for compiled code."""

    broadphase: BroadphaseScene
    mesh: MeshGrid
    triangles: TriangleTree
    obstacles: ObstacleArrays
    spheres: SphereTree
    distance: DistanceField
    cable_rows: Integers  # (shapes of cables,) their rows among the ends
    # whether bodies keep their height, so that no motion leads down to the ground
    constant_height: bool
    clearance: float  # [m] that must be left beside obstacles, which takes it off the room


def collision_scene(
    bodies: Sequence[BodyGeometry],
    world: World,
    *,
    cables: Sequence[CableGeometry] = (),
    self_pairs: Sequence[tuple[str, str]] = (),
    glides: bool = False,
) -> CollisionScene:
    """Gather what ``clearance_within`` needs; most arguments are those of ``CollisionChecker``."""
    shapes = [shape for body in bodies for shape in body.shapes]
    broadphase, mesh = make_broadphase(bodies, cables, world, self_pairs)
    sizes = broadphase.half[: len(shapes)]
    finest = CELL_FRACTION * float(sizes[sizes > 0].min(initial=math.inf))
    grid = _grid(world, finest if math.isfinite(finest) else 0.0)
    return CollisionScene(
        broadphase,
        mesh,
        triangle_tree(mesh.triangles),
        obstacle_arrays(world),
        sphere_tree(shapes, grid.width),
        grid,
        np.flatnonzero([cable.collides for cable in cables]).astype(np.int64),
        glides,
        world.clearance,
    )


def _grid(world: World, finest: float) -> DistanceField:
    with _one_at_a_time:  # threads that begin together want the same one
        return _kept(_World(world, digest(world.obstacles)), finest)


class _World:
    """A world as a key: equal where its obstacles are."""

    def __init__(self, world: World, name: str) -> None:
        self.world, self.name = world, name

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _World) and other.name == self.name

    def __hash__(self) -> int:
        return hash(self.name)


@lru_cache(maxsize=4)
def _kept(world: _World, finest: float) -> DistanceField:
    return cached_distance_field(world.world.obstacles, finest, world.name)


@kernel
def clearance_within(poses, ends, least, wanted, need, fine, scratch, scene):  # type: ignore[no-untyped-def]
    """Bound the room of a placed machine from below, in [m].

    Args:
        poses: One row [R | p] per body, shape (bodies, 12).
        ends: Of the cables, shape (cables, 6).
        least: Less room than this in [m] need not be told apart.
        wanted: Room in [m] that is looked for even where it must be worked out.
        need: More room than this in [m] is of no interest.
        fine: Where the grid shows this much room in [m], its bound is good enough.
        scratch: ``Scratch``.
        scene: ``CollisionScene``.

    Returns:
        A bound, at most ``need``. Between ``least`` and the smaller of ``fine`` and ``need`` it is
        exact but for ``TOUCHING_MARGIN``; below ``least`` where the room is; 0 or less where
        anything touches, sinks into the ground, is inside a solid or is not finite.
    """
    broadphase, distance, kept = scene.broadphase, scene.distance, scene.clearance
    turns, places, around = scratch.turns, scratch.places, scratch.around
    shapes, cable_rows = broadphase.kind.shape[0], scene.cable_rows
    solid = shapes - cable_rows.shape[0]
    best = min(need, ground_clearance(poses, scratch, scene))
    for c in range(cable_rows.shape[0]):
        if not finite(ends[cable_rows[c]]):
            return -1.0
        s = solid + c
        span(ends[cable_rows[c]], broadphase.half[s], turns[s], places[s])
    for s in range(shapes):
        if best <= 0.0:
            return best
        if s < solid:
            free = sphere_tree_clearance(
                s, turns[s], places[s], min(best, fine) + kept, best + kept, scene.spheres,
                distance, scratch,
            )  # fmt: skip
        else:
            most = min(best, fine) + kept
            free = cable_clearance(broadphase.half[s], turns[s], places[s], most, distance)
        free -= kept
        if free < min(best, fine):
            enclose(broadphase.kind[s], broadphase.half[s], turns[s], places[s], 0.0, around[s])
            within = min(best, max(SEARCH_FACTOR * fine, wanted)) + kept + TOUCHING_MARGIN
            free = obstacle_clearance(
                s, turns[s], places[s], around[s], least + kept, within, scene, scratch
            )
            free -= kept
        best = min(best, free)
    return min(best, self_clearance(best, least, scratch, scene))


@kernel
def ground_clearance(poses, scratch, scene):  # type: ignore[no-untyped-def]
    """Place the bodies' shapes, and bound their room above the ground; negative in it."""
    broadphase, best = scene.broadphase, math.inf
    for s in range(broadphase.kind.shape[0] - scene.cable_rows.shape[0]):
        pose = poses[broadphase.body[s]]
        for j in range(12):
            if not math.isfinite(pose[j]):
                return -1.0
        turn = scratch.turns[s]
        place(pose, broadphase.own[s], turn, scratch.places[s])
        if broadphase.ground:
            reach = half_extent(
                broadphase.kind[s], broadphase.half[s], turn[2, 0], turn[2, 1], turn[2, 2]
            )
            low = scratch.places[s, 2] - reach
            if low < -MAX_PENETRATION or not (broadphase.rests[s] or low > TOUCHING_MARGIN):
                return -1.0
            if not (broadphase.rests[s] or scene.constant_height):
                best = min(best, low - TOUCHING_MARGIN)
    return best


@kernel
def self_clearance(best, least, scratch, scene):  # type: ignore[no-untyped-def]
    """Bound the room of placed shapes that must not touch each other, if it is below ``best``."""
    broadphase, turns, places = scene.broadphase, scratch.turns, scratch.places
    around = scratch.around
    for k in range(broadphase.own_pairs.shape[0]):
        a, b = broadphase.own_pairs[k, 0], broadphase.own_pairs[k, 1]
        for s in (a, b):
            enclose(broadphase.kind[s], broadphase.half[s], turns[s], places[s], 0.0, around[s])
        if 0.5 * box_gap(around[a], around[b]) - TOUCHING_MARGIN < best:
            gap = separation_within(
                Convex(broadphase.kind[a], broadphase.half[a], turns[a], places[a]),
                Convex(broadphase.kind[b], broadphase.half[b], turns[b], places[b]),
                2.0 * (least + TOUCHING_MARGIN), math.inf, scratch.simplex,
            )  # fmt: skip
            best = min(best, 0.5 * gap - TOUCHING_MARGIN)
    return best


@kernel
def sphere_tree_clearance(s, turn, at, need, enough, spheres, grid, scratch):  # type: ignore[no-untyped-def]
    """Bound the room of a shape by its balls.

    Less than ``need`` is not worked out in full, and more than ``enough`` is of no interest.

    Args:
        s: The shape's row.
        turn, at: Its rotation (3, 3) and centre (3,) in [m].
        need, enough: In [m].
        spheres, grid, scratch: ``SphereTree``, ``DistanceField`` and ``Scratch``.
    """
    child, radii, waiting, frees = spheres.child, spheres.radius, scratch.queue, scratch.gaps
    best, left, looked = math.inf, 1, 0
    waiting[0], frees[0] = (
        spheres.root[s],
        sphere_clearance(spheres.root[s], turn, at, spheres, grid),
    )
    while left > 0:
        left -= 1
        ball, free = waiting[left], frees[left]
        # Smaller balls would show at most their radius more.
        if free >= enough or free >= max(need, radii[ball]):
            best = min(best, free)
            continue
        one, other = child[ball, 0], child[ball, 1]
        looked += 1
        if (one < 0 and other < 0) or looked > MAX_SUBDIVISIONS:
            best = min(best, free)
            if best < need:
                break  # what is near must be looked at
            continue
        free_one = sphere_clearance(one, turn, at, spheres, grid) if one >= 0 else math.inf
        free_other = sphere_clearance(other, turn, at, spheres, grid) if other >= 0 else math.inf
        if free_one < free_other:  # the one with less room goes on top
            one, other, free_one, free_other = other, one, free_other, free_one
        if one >= 0:
            waiting[left], frees[left] = one, free_one
            left += 1
        waiting[left], frees[left] = other, free_other
        left += 1
    return best


@kernel
def sphere_clearance(ball, turn, at, spheres, grid):  # type: ignore[no-untyped-def]
    """Bound the room of one ball of a placed shape.

    Args:
        ball: Its row in the tree.
        turn, at: The shape's rotation (3, 3) and centre (3,) in [m].
        spheres, grid: ``SphereTree`` and ``DistanceField``.
    """
    u, v, w = spheres.center[ball, 0], spheres.center[ball, 1], spheres.center[ball, 2]
    x = at[0] + turn[0, 0] * u + turn[0, 1] * v + turn[0, 2] * w - grid.low[0]
    y = at[1] + turn[1, 0] * u + turn[1, 1] * v + turn[1, 2] * w - grid.low[1]
    z = at[2] + turn[2, 0] * u + turn[2, 1] * v + turn[2, 2] * w - grid.low[2]
    return distance_bound(grid.width, grid.distance, x, y, z) - spheres.radius[ball]


@kernel
def cable_clearance(half, turn, at, need, grid):  # type: ignore[no-untyped-def]
    """Bound the room of a cable by balls around its pieces, as ``sphere_tree_clearance`` does.

    Args:
        half: Half sizes in [m], shape (3,).
        turn, at: Rotation (3, 3) and centre (3,) in [m].
        need: In [m]; whether there is less is told, and not by how much.
        grid: ``DistanceField``.
    """
    best, piece = math.inf, half[2] / CABLE_SPHERES
    radius = math.hypot(half[0], piece) if piece > half[0] else half[0] + piece
    for i in range(CABLE_SPHERES):
        z = (2 * i + 1) * piece - half[2]
        x, y, z = at[0] + turn[0, 2] * z, at[1] + turn[1, 2] * z, at[2] + turn[2, 2] * z
        x, y, z = x - grid.low[0], y - grid.low[1], z - grid.low[2]
        best = min(best, distance_bound(grid.width, grid.distance, x, y, z) - radius)
        if best < need:
            break
    return best


@kernel
def obstacle_clearance(s, turn, at, box, least, within, scene, scratch):  # type: ignore[no-untyped-def]
    """Work out the room of one shape less MARGIN, if it is below ``within``; 0 inside a solid.

    Args:
        s: The shape's row.
        turn, at: Its rotation (3, 3) and centre (3,) in [m].
        box: Lowest and highest x, y, z in [m], shape (6,).
        least, within: In [m]; room below ``least`` is told, and not by how much.
        scene, scratch: ``CollisionScene`` and ``Scratch``.
    """
    least += TOUCHING_MARGIN
    broadphase, fixed = scene.broadphase, scene.obstacles
    shape = Convex(broadphase.kind[s], broadphase.half[s], turn, at)
    best = mesh_clearance(shape, box, least, within, scene.triangles, scratch)
    for k in range(broadphase.obstacle.shape[0]):
        if best < least or best <= TOUCHING_MARGIN:
            break
        if box_gap(box, broadphase.obstacle[k]) >= best:
            continue
        if broadphase.mesh[k] < 0:
            other = Convex(fixed.kind[k], fixed.half[k], fixed.turn[k], fixed.at[k])
            best = min(best, separation_within(shape, other, least, best, scratch.simplex))
        elif inside(at, broadphase.mesh[k], scene.mesh):
            return -1.0
    return best - TOUCHING_MARGIN


@kernel
def mesh_clearance(shape, box, least, within, tree, scratch):  # type: ignore[no-untyped-def]
    """Bound the gap between a shape and all triangles, if it is below ``within``.

    Args:
        shape: ``Convex``.
        box: Lowest and highest x, y, z in [m], shape (6,).
        least, within: In [m]; a gap below ``least`` is told, and not by how much.
        tree, scratch: ``TriangleTree`` and ``Scratch``.
    """
    best, waiting, gaps = within, scratch.queue, scratch.gaps
    if tree.boxes.shape[0] == 0:
        return best
    waiting[0], gaps[0], left = 0, 0.0, 1
    while left > 0:
        left -= 1
        node = waiting[left]
        if gaps[left] >= best:
            continue
        if tree.child[node, 0] < 0:
            for t in range(tree.span[node, 0], tree.span[node, 1]):
                if plane_bound(shape, tree.planes[t]) >= best:
                    continue
                if own_bound(shape, tree.triangles[t]) >= best:
                    continue
                gap = to_triangle(shape, tree.triangles[t], least, best, scratch)
                best = min(best, gap)
                if best < least or best <= TOUCHING_MARGIN:
                    return best
            continue
        one, other = tree.child[node, 0], tree.child[node, 1]
        gap_one = box_bound(shape, box, tree.boxes[one])
        gap_other = box_bound(shape, box, tree.boxes[other])
        if gap_one < gap_other:  # the nearer one goes on top
            one, other, gap_one, gap_other = other, one, gap_other, gap_one
        waiting[left], gaps[left] = one, gap_one
        waiting[left + 1], gaps[left + 1] = other, gap_other
        left += 2
    return best


@kernel
def to_triangle(shape, triangle, least, enough, scratch):  # type: ignore[no-untyped-def]
    """Bound the gap between a shape and a triangle (9,).

    Args:
        shape: ``Convex``.
        triangle: Corners in [m], shape (9,).
        least, enough: In [m], as ``separation_within`` takes them.
        scratch: ``Scratch``.
    """
    corners = scratch.corners
    for i in range(9):
        corners[i % 3, i // 3] = triangle[i]
    other = Convex(TRIANGLE, shape.half, corners, triangle)
    return separation_within(shape, other, least, enough, scratch.simplex)


@kernel
def plane_bound(shape, plane):  # type: ignore[no-untyped-def]
    """Bound the gap between a shape and what lies in a plane (4,): unit normal and offset."""
    turn, at = shape.turn, shape.at
    a, b, c = plane[0], plane[1], plane[2]
    away = abs(a * at[0] + b * at[1] + c * at[2] - plane[3])
    x = a * turn[0, 0] + b * turn[1, 0] + c * turn[2, 0]
    y = a * turn[0, 1] + b * turn[1, 1] + c * turn[2, 1]
    z = a * turn[0, 2] + b * turn[1, 2] + c * turn[2, 2]
    return away - half_extent(shape.kind, shape.half, x, y, z)


@kernel
def box_bound(shape, around, box):  # type: ignore[no-untyped-def]
    """Bound the gap between a shape and a box (6,): along the world's axes, and along its own."""
    turn, at = shape.turn, shape.at
    total = 0.0
    a, b, c = 0.5 * (box[3] - box[0]), 0.5 * (box[4] - box[1]), 0.5 * (box[5] - box[2])
    u, v, w = a + box[0] - at[0], b + box[1] - at[1], c + box[2] - at[2]
    for i in range(3):
        x, y, z = turn[0, i], turn[1, i], turn[2, i]
        away = abs(x * u + y * v + z * w) - abs(x) * a - abs(y) * b - abs(z) * c
        gap = max(away - reach_along(shape.kind, shape.half, i), 0.0)
        total += gap * gap
    return max(math.sqrt(total), box_gap(around, box))


@kernel
def own_bound(shape, triangle):  # type: ignore[no-untyped-def]
    """Bound the gap between a shape and a triangle (9,) along the shape's own axes."""
    turn, at = shape.turn, shape.at
    total = 0.0
    for i in range(3):
        x, y, z = turn[0, i], turn[1, i], turn[2, i]
        middle = x * at[0] + y * at[1] + z * at[2]
        one = x * triangle[0] + y * triangle[1] + z * triangle[2]
        two = x * triangle[3] + y * triangle[4] + z * triangle[5]
        three = x * triangle[6] + y * triangle[7] + z * triangle[8]
        low, high = min(one, two, three) - middle, max(one, two, three) - middle
        gap = max(max(low, -high) - reach_along(shape.kind, shape.half, i), 0.0)
        total += gap * gap
    return math.sqrt(total)


class ClearanceBound:
    """Asks ``clearance_within`` from Python, with scratch memory of its own: one for every thread.

    Args:
        scene: The machine's shapes and the world.
    """

    def __init__(self, scene: CollisionScene) -> None:
        # The lengths of cables are written into the scene.
        half = scene.broadphase.half.copy()
        self._around = Record(scene._replace(broadphase=scene.broadphase._replace(half=half)))
        self._scratch = Record(scratch_for(scene))

    def within(self, poses: Array, ends: Array, need: float, fine: float = math.inf) -> float:
        """Return the room of a pose, as ``clearance_within`` does."""
        table, cable_rows = poses.reshape(-1, 12), ends.reshape(-1, 6)
        return float(
            clearance_within(table, cable_rows, 0.0, 0.0, need, fine, self._scratch, self._around)
        )
