"""Certified clearance: how far every point of a machine may move before anything can touch.

Cheap bounds come first: balls that contain the bodies, in a grid of distances. Where these are not
enough, the distance to what is near is worked out exactly. No answer is ever too large, and none is
below the true clearance by more than ``TOUCHING_MARGIN`` where that is smaller than was asked for.
"""

from __future__ import annotations

import math

from kinolab.numerics.arrays import Array, allocate
from kinolab.numerics.jit import kernel
from kinolab.numerics.struct import Record
from kinolab.world.collision.broadphase import MAX_PENETRATION, Scratch, place
from kinolab.world.collision.collision_scene import CollisionScene
from kinolab.world.distances.distance_field import distance_bound
from kinolab.world.distances.gjk import Convex, box_gap, separation_within
from kinolab.world.distances.obstacle_blocks import following
from kinolab.world.distances.placed_shapes import enclose
from kinolab.world.distances.triangle_gaps import TOUCHING_MARGIN, mesh_clearance
from kinolab.world.distances.triangle_grid import inside
from kinolab.world.shapes.cable import finite, span
from kinolab.world.shapes.support_functions import half_extent

CABLE_SPHERES = 16  # balls along a cable


@kernel
def clearance_within(poses, ends, least, wanted, need, fine, scratch, scene):  # type: ignore[no-untyped-def]
    """Bound the clearance of a placed machine from below, in [m].

    Args:
        poses: One row [R | p] per body, shape (bodies, 12).
        ends: Of the cables, shape (cables, 6).
        least: Less clearance than this in [m] need not be told apart.
        wanted: Room in [m] that is looked for even where it must be worked out.
        need: More clearance than this in [m] is of no interest.
        fine: Where the grid shows this much clearance in [m], its bound is good enough.
        scratch: ``Scratch``.
        scene: ``CollisionScene``.

    Returns:
        A bound, at most ``need``. Between ``least`` and the smaller of ``fine`` and ``need`` it is
        exact but for ``TOUCHING_MARGIN``; below ``least`` where the clearance is; 0 or less where
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
        if broadphase.paired[s]:
            continue
        if s < solid:
            free = sphere_tree_clearance(
                s, turns[s], places[s], min(best, fine) + kept, best + kept, scene.spheres,
                distance, scratch,
            )  # fmt: skip
        else:
            most = min(best, fine) + kept
            free = cable_clearance(broadphase.half[s], turns[s], places[s], most, distance)
        if scene.loose.shape[0] or free - kept < min(best, fine):
            enclose(broadphase.kind[s], broadphase.half[s], turns[s], places[s], 0.0, around[s])
        for k in scene.loose:  # which the grid does not know
            free = min(free, box_gap(around[s], broadphase.obstacle[k]))
        free -= kept
        if free < min(best, fine):
            # times ``fine``: how far away what is near is looked for
            within = min(best, max(2.0 * fine, wanted)) + kept + TOUCHING_MARGIN
            free = obstacle_clearance(
                s, turns[s], places[s], around[s], least + kept, within, fine + kept, scene, scratch
            )
            free -= kept
        best = min(best, free)
    return min(best, self_clearance(best, least, scratch, scene))


@kernel
def ground_clearance(poses, scratch, scene):  # type: ignore[no-untyped-def]
    """Place the bodies' shapes, and bound their clearance above the ground; negative in it."""
    broadphase, best = scene.broadphase, math.inf
    for s in range(broadphase.kind.shape[0] - scene.cable_rows.shape[0]):
        pose = poses[broadphase.body[s]]
        for j in range(12):
            if not math.isfinite(pose[j]):
                return -1.0
        turn = scratch.turns[s]
        place(pose, broadphase.own[s], turn, scratch.places[s])
        if broadphase.ground and not broadphase.paired[s]:
            reach = half_extent(
                broadphase.kind[s], broadphase.half[s], -turn[2, 0], -turn[2, 1], -turn[2, 2]
            )
            low = scratch.places[s, 2] - reach
            if low < -MAX_PENETRATION or not (broadphase.rests[s] or low > TOUCHING_MARGIN):
                return -1.0
            if not (broadphase.rests[s] or scene.constant_height):
                best = min(best, low - TOUCHING_MARGIN)
    return best


@kernel
def self_clearance(best, least, scratch, scene):  # type: ignore[no-untyped-def]
    """Bound the clearance between placed shapes that must not touch, if it is below ``best``."""
    broadphase, turns, places = scene.broadphase, scratch.turns, scratch.places
    around = scratch.around
    for k in range(broadphase.own_pairs.shape[0]):
        a, b = broadphase.own_pairs[k, 0], broadphase.own_pairs[k, 1]
        for s in (a, b):
            enclose(broadphase.kind[s], broadphase.half[s], turns[s], places[s], 0.0, around[s])
        kept = broadphase.kept[k]
        if 0.5 * (box_gap(around[a], around[b]) - kept) - TOUCHING_MARGIN < best:
            gap = separation_within(
                Convex(broadphase.kind[a], broadphase.half[a], turns[a], places[a]),
                Convex(broadphase.kind[b], broadphase.half[b], turns[b], places[b]),
                2.0 * (least + TOUCHING_MARGIN) + kept, math.inf, scratch.simplex,
            )  # fmt: skip
            best = min(best, 0.5 * (gap - kept) - TOUCHING_MARGIN)
    return best


@kernel
def sphere_tree_clearance(s, turn, at, need, enough, spheres, grid, scratch):  # type: ignore[no-untyped-def]
    """Bound the clearance of a shape by its balls.

    Less than ``need`` is not worked out in full, and more than ``enough`` is of no interest.

    Args:
        s: The shape's row.
        turn, at: Its rotation (3, 3) and centre (3,) in [m].
        need, enough: In [m].
        spheres, grid, scratch: ``SphereTree``, ``DistanceField`` and ``Scratch``.
    """
    child, radii, waiting, frees = spheres.child, spheres.radius, scratch.queue, scratch.gaps
    best, left, looked = math.inf, 1, 0
    waiting[0] = spheres.root[s]
    frees[0] = sphere_clearance(spheres.root[s], turn, at, spheres, grid)
    while left > 0:
        left -= 1
        ball, free = waiting[left], frees[left]
        # Smaller balls would show at most their radius more.
        if free >= enough or free >= max(need, radii[ball]):
            best = min(best, free)
            continue
        one, other = child[ball, 0], child[ball, 1]
        looked += 1
        if (one < 0 and other < 0) or looked > 3:  # balls that are divided
            best = min(best, free)
            if best < need:
                break  # what is near must be looked at
            continue
        free_one = sphere_clearance(one, turn, at, spheres, grid) if one >= 0 else math.inf
        free_other = sphere_clearance(other, turn, at, spheres, grid) if other >= 0 else math.inf
        if free_one < free_other:  # the one with less clearance goes on top
            one, other, free_one, free_other = other, one, free_other, free_one
        if one >= 0:
            waiting[left], frees[left] = one, free_one
            left += 1
        waiting[left], frees[left] = other, free_other
        left += 1
    return best


@kernel
def sphere_clearance(ball, turn, at, spheres, grid):  # type: ignore[no-untyped-def]
    """Bound the clearance of one ball of a placed shape.

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
    """Bound the clearance of a cable by balls around its pieces, as ``sphere_tree_clearance`` does.

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
def obstacle_clearance(s, turn, at, box, least, within, fine, scene, scratch):  # type: ignore[no-untyped-def]
    """Work out the clearance of one shape less MARGIN, if it is below ``within``; 0 inside a solid.

    Args:
        s: The shape's row.
        turn, at: Its rotation (3, 3) and centre (3,) in [m].
        box: Lowest and highest x, y, z in [m], shape (6,).
        least, within: In [m]; clearance below ``least`` is told, and not by how much.
        fine: In [m]; beyond it the answer may be short by a tenth.
        scene, scratch: ``CollisionScene`` and ``Scratch``.
    """
    least, precise = least + TOUCHING_MARGIN, fine + TOUCHING_MARGIN
    broadphase, fixed = scene.broadphase, scene.obstacles
    shape = Convex(broadphase.kind[s], broadphase.half[s], turn, at)
    best = mesh_clearance(shape, box, least, within, scene.triangles, scratch)
    k = -1
    while best >= least and best > TOUCHING_MARGIN:
        k = following(k + 1, box, best, fixed)
        if k == broadphase.obstacle.shape[0]:
            break
        if box_gap(box, broadphase.obstacle[k]) >= best:
            continue
        if broadphase.mesh[k] < 0:
            other = Convex(fixed.kind[k], fixed.half[k], fixed.turn[k], fixed.at[k])
            gap = separation_within(shape, other, least, best, scratch.simplex, precise)
            best = min(best, gap)
        elif inside(at, broadphase.mesh[k], scene.mesh):
            return -1.0
    return best - TOUCHING_MARGIN


class ClearanceBound:
    """Asks ``clearance_within`` from Python, with scratch memory of its own: one for every thread.

    Args:
        scene: The machine's shapes and the world.
    """

    def __init__(self, scene: CollisionScene) -> None:
        # The lengths of cables are written into the scene.
        half = scene.broadphase.half.copy()
        self._around = Record(scene._replace(broadphase=scene.broadphase._replace(half=half)))
        self._scratch = Record(allocate(Scratch, {"shapes": len(half), "pairs": 1}))

    def within(self, poses: Array, ends: Array, need: float, fine: float = math.inf) -> float:
        """Return the clearance of a pose, as ``clearance_within`` does."""
        table, cable_rows = poses.reshape(-1, 12), ends.reshape(-1, 6)
        return float(
            clearance_within(table, cable_rows, 0.0, 0.0, need, fine, self._scratch, self._around)
        )
