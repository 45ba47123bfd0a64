"""The compiled screen before FCL: places the bodies and lists the pairs that only FCL can decide.

The screen never says "free" where something touches. It proves most poses free from axis-aligned
boxes, finds bodies below the ground and inside solids, and hands on what is left.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.language.shapes import Shape
from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.world.cable import CableGeometry, span_all
from kinolab.world.collision.clearance import ObstacleArrays
from kinolab.world.collision.triangle_grid import Integers, MeshGrid, mesh_grid
from kinolab.world.geometry import (
    BodyGeometry,
    ShapeKind,
    placement,
    sizes,
)
from kinolab.world.support_functions import half_extent
from kinolab.world.world import World

# Verdicts of ``broadphase``; a number above 0 counts the pairs that are left for FCL.
FREE, NOT_FINITE, GROUND, INSIDE = 0, -1, -2, -3
MAX_PENETRATION = 1e-6  # [m] that a wheel or a foot may press into the ground
MAX_TRIANGLE_CHECKS = 256  # triangles looked at before FCL's tree is the better judge
ROUNDING_MARGIN = 1e-9  # [m] that absorbs rounding, far above it at world coordinates of 1e5 m


class BroadphaseScene(NamedTuple):
    """Shapes of the machine and obstacles of the world in flat arrays, for compiled code.

    Cables are the last shapes; their lengths in ``half`` are those of the last pose.
    """

    kind: Integers  # (shapes,) values of ``geometry.ShapeKind``
    body: Integers  # (shapes,) rows of the pose table, -1 for a cable
    half: Array  # (shapes, 3) half sizes in [m]
    own: Array  # (shapes, 3, 4) the shape's own frame in its body's frame; of a cable unused
    rests: NDArray[np.bool_]  # (shapes,) whether it may touch the ground, as cables may
    obstacle: Array  # (obstacles, 6) lowest and highest x, y, z in [m]
    mesh: Integers  # (obstacles,) which mesh of the grid, -1 for a primitive
    own_pairs: Integers  # (pairs, 2) shapes that may not touch each other
    grow: float  # [m] that bodies are inflated by
    margin: float  # [m] to keep from the ground
    ground: bool


class BroadphaseScratch(NamedTuple):
    """Where the machine's shapes are, and what is left for FCL, for compiled code."""

    turns: Array  # (shapes, 3, 3)
    places: Array  # (shapes, 3)
    around: Array  # (shapes, 6) boxes
    # (shapes * obstacles + own pairs + 1, 2): shape and obstacle of each pair that is left, for two
    # shapes of the machine (shape, obstacles + other shape)
    pairs: Integers


class CheckerArrays(NamedTuple):
    """All that is known of a machine in its world, for compiled code: one record to hand over."""

    scratch: BroadphaseScratch
    scene: BroadphaseScene
    grid: MeshGrid
    obstacles: ObstacleArrays


def make_broadphase(
    bodies: Sequence[BodyGeometry],
    cables: Sequence[CableGeometry],
    world: World,
    own_pairs: Sequence[tuple[int, int]],
) -> tuple[BroadphaseScene, MeshGrid]:
    """Gather the arrays of ``CheckerArrays``.

    Of ``cables`` only those that collide are given. Nothing is inflated yet.
    """
    parts = [(k, body, shape) for k, body in enumerate(bodies) for shape in body.shapes]
    measured = [sizes(shape) for _, _, shape in parts]
    lines = len(cables)
    meshes = [obstacle for obstacle in world.obstacles if obstacle.primitive is None]
    mesh = np.array([obstacle.primitive is None for obstacle in world.obstacles], dtype=bool)
    boxes = [np.concatenate(bounding_box(o.vertices, o.primitive)) for o in world.obstacles]
    scene = BroadphaseScene(
        kind=np.array(
            [*(int(kind) for kind, _ in measured), *[int(ShapeKind.CAPSULE)] * lines],
            dtype=np.int64,
        ),
        body=np.array([*(k for k, _, _ in parts), *[-1] * lines], dtype=np.int64),
        half=np.array(
            [*(half for _, half in measured), *([c.radius, c.radius, 0.0] for c in cables)]
        ).reshape(-1, 3),
        own=np.array(
            [*(placement(shape) for _, _, shape in parts), *[np.eye(3, 4)] * lines]
        ).reshape(-1, 3, 4),
        rests=np.array(
            [*(body.touches_ground for _, body, _ in parts), *[True] * lines], dtype=bool
        ),
        obstacle=np.array(boxes).reshape(-1, 6),
        mesh=np.where(mesh, np.cumsum(mesh) - 1, -1).astype(np.int64),
        own_pairs=np.array(own_pairs, dtype=np.int64).reshape(-1, 2),
        grow=0.0,
        margin=0.0,
        ground=world.ground,
    )
    return scene, mesh_grid(meshes)


def bounding_box(vertices: Array, primitive: tuple[Shape, Array] | None) -> tuple[Array, Array]:
    """Give the lowest and highest (x, y, z); of a primitive exactly, not of its vertices (n, 3)."""
    if primitive is None:
        return vertices.min(axis=0), vertices.max(axis=0)
    shape, pose = primitive
    kind, half = sizes(shape)
    own = placement(shape)
    center, turn = pose[:, :3] @ own[:, 3] + pose[:, 3], pose[:, :3] @ own[:, :3]
    extent = np.array([half_extent(int(kind), half, *turn[axis]) for axis in range(3)])
    return center - extent, center + extent


@kernel
def place(pose, own, turn, at):  # type: ignore[no-untyped-def]
    """Compose a body's pose (12,) with a shape's own frame (3, 4) into R (3, 3) and p (3,)."""
    for i in range(3):
        r = 4 * i
        for j in range(3):
            turn[i, j] = pose[r] * own[0, j] + pose[r + 1] * own[1, j] + pose[r + 2] * own[2, j]
        at[i] = (
            pose[r] * own[0, 3] + pose[r + 1] * own[1, 3] + pose[r + 2] * own[2, 3] + pose[r + 3]
        )


@kernel
def enclose(kind, half, turn, at, grow, box):  # type: ignore[no-untyped-def]
    """Write the axis-aligned box (6,) of a placed shape, ``grow`` larger on every side.

    Args:
        kind, half: The shape's kind and half sizes (3,) in [m].
        turn, at: Its rotation (3, 3) and centre (3,) in [m].
        grow: In [m].
        box: Lowest and highest x, y, z in [m], shape (6,); written.
    """
    for i in range(3):
        reach = half_extent(kind, half, turn[i, 0], turn[i, 1], turn[i, 2]) + grow
        box[i] = at[i] - reach
        box[i + 3] = at[i] + reach


@kernel
def grounded(low, rests, margin):  # type: ignore[no-untyped-def]
    """Say whether a shape whose lowest point is at ``low`` is too low for its body."""
    return low < -MAX_PENETRATION if rests else low - margin <= ROUNDING_MARGIN


@kernel
def overlap(a, b):  # type: ignore[no-untyped-def]
    """Say whether two boxes (6,) share a point."""
    return (
        a[0] <= b[3]
        and b[0] <= a[3]
        and a[1] <= b[4]
        and b[1] <= a[4]
        and a[2] <= b[5]
        and b[2] <= a[5]
    )


@kernel
def cell_of(offset, count):  # type: ignore[no-untyped-def]
    """Give the cell at an offset counted in cells, the first or last one beyond the grid."""
    return int(min(max(offset, 0.0), count - 1.0))


@kernel
def near_surface(box, mesh, grid):  # type: ignore[no-untyped-def]
    """Say whether a box (6,) may touch a triangle of a mesh; True after looking at too many."""
    boxes, frame, extent = grid.boxes, grid.frame, grid.extent
    start, entries = grid.start, grid.entries
    x, y, width = frame[mesh, 0], frame[mesh, 1], frame[mesh, 2]
    nx, ny, cell = extent[mesh, 0], extent[mesh, 1], extent[mesh, 2]
    left, right = cell_of((box[0] - x) / width, nx), cell_of((box[3] - x) / width, nx)
    front, back = cell_of((box[1] - y) / width, ny), cell_of((box[4] - y) / width, ny)
    looks = 0
    for row in range(front, back + 1):
        for here in range(cell + row * nx + left, cell + row * nx + right + 1):
            for k in range(start[here], start[here + 1]):
                if overlap(box, boxes[entries[k]]):
                    return True
            looks += start[here + 1] - start[here] + 1
            if looks > MAX_TRIANGLE_CHECKS:
                return True
    return False


@kernel
def left_of(x, y, ax, ay, bx, by):  # type: ignore[no-untyped-def]
    """Say whether (x, y) lies left of the edge, given its ends in any order, at its height.

    The lower end always comes first in the arithmetic, so that both triangles at an edge get the
    same answer to the last bit, and a line through an edge or a corner is counted once.

    Args:
        x, y: The point in [m].
        ax, ay, bx, by: The ends in [m].
    """
    if ay > by or (ay == by and ax > bx):
        ax, ay, bx, by = bx, by, ax, ay
    return (bx - ax) * (y - ay) - (x - ax) * (by - ay) > 0.0


@kernel
def shadow(x, y, t):  # type: ignore[no-untyped-def]
    """Say whether (x, y) is in the triangle (9,) seen from above: 1 or -1 by its turn, else 0."""
    crossings, winding = 0, 0
    for k in range(3):
        ax, ay = t[3 * k], t[3 * k + 1]
        bx, by = t[3 * ((k + 1) % 3)], t[3 * ((k + 1) % 3) + 1]
        if (ay > y) != (by > y) and left_of(x, y, ax, ay, bx, by):
            crossings += 1
            winding += 1 if by > ay else -1
    return winding if crossings == 1 else 0


@kernel
def height(x, y, t):  # type: ignore[no-untyped-def]
    """Give the z of a triangle's plane at (x, y), kept between its lowest and highest corner.

    A triangle that is steep to the last bit has an ill-determined height, but then (x, y) is
    within rounding of the triangle itself.
    """
    ux, uy, uz = t[3] - t[0], t[4] - t[1], t[5] - t[2]
    vx, vy, vz = t[6] - t[0], t[7] - t[1], t[8] - t[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    z = t[2] if nz == 0.0 else t[2] - (nx * (x - t[0]) + ny * (y - t[1])) / nz
    return min(max(z, min(t[2], t[5], t[8])), max(t[2], t[5], t[8]))


@kernel
def inside(p, mesh, grid):  # type: ignore[no-untyped-def]
    """Say whether a point (3,) lies in the solid of a mesh.

    Counts the faces above the point by the way they look, part by part. The smallest closed part
    around the point decides: a pillar in a room is solid, a room in a rock is not.
    """
    triangles, part, volume = grid.triangles, grid.part, grid.volume
    frame, extent, start, entries = grid.frame, grid.extent, grid.start, grid.entries
    nx, ny = extent[mesh, 0], extent[mesh, 1]
    column, row = (p[0] - frame[mesh, 0]) / frame[mesh, 2], (p[1] - frame[mesh, 1]) / frame[mesh, 2]
    if not (0.0 <= column <= nx and 0.0 <= row <= ny):
        return False
    here = extent[mesh, 2] + cell_of(row, ny) * nx + cell_of(column, nx)
    smallest, winding, current = math.inf, 0, -1
    verdict = False
    for k in range(start[here], start[here + 1] + 1):
        last = k == start[here + 1]
        if last or part[entries[k]] != current:
            if winding != 0 and abs(volume[current]) < smallest:
                smallest, verdict = abs(volume[current]), volume[current] > 0.0
            if last:
                break
            current, winding = part[entries[k]], 0
        if volume[current] != 0.0:
            turn = shadow(p[0], p[1], triangles[entries[k]])
            if turn != 0 and height(p[0], p[1], triangles[entries[k]]) > p[2]:
                winding += turn
    return verdict


@kernel
def first_not_finite(poses):  # type: ignore[no-untyped-def]
    """Give the first row of a pose table with NaN or infinity in it, -1 where there is none."""
    for k in range(poses.shape[0]):
        for j in range(12):
            if not math.isfinite(poses[k, j]):
                return k
    return -1


@kernel
def broadphase(poses, arrays):  # type: ignore[no-untyped-def]
    """Judge one pose of the machine as far as boxes, the ground and solids decide it.

    Args:
        poses: One row [R | p] per body, shape (bodies, 12).
        arrays: ``CheckerArrays``; its scratch is written, but read where cables are.

    Returns:
        The number of pairs left, or NOT_FINITE, GROUND or INSIDE: then the first row of ``pairs``
        says which body, -1 for a cable, and which obstacle it is inside of.
    """
    scratch, scene, grid = arrays.scratch, arrays.scene, arrays.grid
    turns, places, around, pairs = scratch.turns, scratch.places, scratch.around, scratch.pairs
    kind, body, half, own_pairs = scene.kind, scene.body, scene.half, scene.own_pairs
    obstacle, mesh, grow = scene.obstacle, scene.mesh, scene.grow
    pairs[0, 0] = first_not_finite(poses)
    if pairs[0, 0] >= 0:
        return NOT_FINITE
    for s in range(kind.shape[0]):
        if body[s] >= 0:
            place(poses[body[s]], scene.own[s], turns[s], places[s])
        enclose(kind[s], half[s], turns[s], places[s], grow + ROUNDING_MARGIN, around[s])
        if (
            scene.ground
            and body[s] >= 0
            and grounded(around[s, 2] + grow + ROUNDING_MARGIN, scene.rests[s], scene.margin)
        ):
            pairs[0, 0] = body[s]
            return GROUND
    left = 0
    for s in range(kind.shape[0]):
        for k in range(obstacle.shape[0]):
            if not overlap(around[s], obstacle[k]):
                continue
            if mesh[k] >= 0:
                if inside(places[s], mesh[k], grid):
                    pairs[0, 0], pairs[0, 1] = body[s], k
                    return INSIDE
                if not near_surface(around[s], mesh[k], grid):
                    continue
            pairs[left, 0], pairs[left, 1] = s, k
            left += 1
    for k in range(own_pairs.shape[0]):
        if overlap(around[own_pairs[k, 0]], around[own_pairs[k, 1]]):
            pairs[left, 0] = own_pairs[k, 0]
            pairs[left, 1] = obstacle.shape[0] + own_pairs[k, 1]
            left += 1
    return left


@kernel
def broadphase_rows(first, poses, ends, rows, arrays):  # type: ignore[no-untyped-def]
    """Screen pose after pose until there is one that is not proved free.

    Args:
        first: Where to begin.
        poses: Of every body in every pose, shape (poses, bodies, 12).
        ends: Of every cable in every pose, shape (poses, cables, 6).
        rows: Which cables have a shape, as ``span_all`` takes them.
        arrays: ``CheckerArrays``; its scratch is written.

    Returns:
        Which pose it is, the number of poses where there is none; and what ``broadphase`` says of
        it.
    """
    scratch = arrays.scratch
    for k in range(first, poses.shape[0]):
        if not span_all(ends[k], rows, arrays.scene.half, scratch.turns, scratch.places):
            return k, NOT_FINITE
        left = broadphase(poses[k], arrays)
        if left != 0:
            return k, left
    return poses.shape[0], 0
