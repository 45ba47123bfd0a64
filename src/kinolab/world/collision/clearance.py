"""How far every point of the machine may move before anything can touch, as a proved bound."""

from __future__ import annotations

import math

from kinolab.numerics.jit import kernel
from kinolab.world.distances.gjk import Convex, box_gap, separation_within
from kinolab.world.distances.obstacle_blocks import following
from kinolab.world.distances.triangle_gaps import mesh_clearance


@kernel
def clearance_at(arrays, most):  # type: ignore[no-untyped-def]
    """Bound the clearance of placed shapes from below, in [m]; ``most`` in an empty world.

    Two shapes of the machine can approach each other from both sides: half their gap counts, less
    what must be left between them.

    Args:
        arrays: ``CheckerArrays``, as ``broadphase`` left them.
        most: More clearance than this in [m] is of no interest.
    """
    scratch, scene, fixed = arrays.scratch, arrays.scene, arrays.obstacles
    turns, places, around = scratch.turns, scratch.places, scratch.around
    kind, half, obstacle, own_pairs = scene.kind, scene.half, scene.obstacle, scene.own_pairs
    best = most
    for s in range(kind.shape[0]):
        if scene.paired[s]:
            continue
        shape = Convex(kind[s], half[s], turns[s], places[s])
        if scene.ground and not scene.rests[s]:
            best = min(best, around[s, 2] + scene.grow)
        k = -1
        while True:
            k = following(k + 1, around[s], best, fixed)
            if k == obstacle.shape[0]:
                break
            if scene.mesh[k] >= 0 or box_gap(around[s], obstacle[k]) >= best:
                continue
            other = Convex(fixed.kind[k], fixed.half[k], fixed.turn[k], fixed.at[k])
            best = min(best, separation_within(shape, other, 0.0, math.inf, scratch.simplex))
        best = mesh_clearance(shape, around[s], 0.0, best, arrays.tree, scratch)
    for k in range(own_pairs.shape[0]):
        a, b = own_pairs[k, 0], own_pairs[k, 1]
        if 0.5 * (box_gap(around[a], around[b]) - scene.kept[k]) < best:
            gap = separation_within(
                Convex(kind[a], half[a], turns[a], places[a]),
                Convex(kind[b], half[b], turns[b], places[b]),
                0.0, math.inf, scratch.simplex,
            )  # fmt: skip
            best = min(best, 0.5 * (gap - scene.kept[k]))
    return best
