"""The compiled screen before FCL: places the bodies and lists the pairs that only FCL can decide.

The screen never says "free" where something touches. It proves most poses free from axis-aligned
boxes and from gaps to triangles, finds bodies below the ground and inside solids, and hands on what
is left. So FCL's search tree of a large mesh is built only where something comes near to it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.facts.machine_facts import BodyGeometry, CableGeometry
from kinolab.dynamics.language.shapes import ShapeKind
from kinolab.errors import UnknownNameError
from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.world.collision.clearance import clearance_at
from kinolab.world.distances.gjk import Convex
from kinolab.world.distances.obstacle_blocks import following
from kinolab.world.distances.placed_shapes import ObstacleArrays, enclose, obstacle_arrays
from kinolab.world.distances.sphere_tree import STACK_SIZE
from kinolab.world.distances.triangle_gaps import mesh_clearance
from kinolab.world.distances.triangle_grid import (
    MeshGrid,
    inside,
    mesh_grid,
    near_surface,
    overlap,
)
from kinolab.world.distances.triangle_tree import Traversal, TriangleTree
from kinolab.world.obstacles.world import World
from kinolab.world.shapes.cable import span_all
from kinolab.world.shapes.geometry import placement, sizes, sizes_of

COLLIDES = -1  # a verdict of ``broadphase``; other numbers count the pairs that are left for FCL
MAX_PENETRATION = 1e-6  # [m] that a wheel or a foot may press into the ground
ROUNDING_MARGIN = 1e-9  # [m] that absorbs rounding, far above it at world coordinates of 1e5 m


class BroadphaseScene(NamedTuple):
    """Shapes of the machine and obstacles of the world in flat arrays, for compiled code.

    Cables are the last shapes; their lengths in ``half`` are those of the last pose.
    """

    kind: Integers  # (shapes,) values of ``ShapeKind``
    body: Integers  # (shapes,) rows of the pose table, -1 for a cable
    half: Array  # (shapes, 3) half sizes in [m], and the corners of hulls, if there are any
    own: Array  # (shapes, 3, 4) the shape's own frame in its body's frame; of a cable unused
    rests: NDArray[np.bool_]  # (shapes,) whether it may touch the ground, as cables may
    obstacle: Array  # (obstacles, 6) lowest and highest x, y, z in [m]
    mesh: Integers  # (obstacles,) which mesh of the grid, -1 for a primitive
    paired: NDArray[np.bool_]  # (shapes,) whether it meets only those that it is paired with
    own_pairs: Integers  # (pairs, 2) shapes that may not touch each other
    kept: Array  # (pairs,) [m] that must be left between them
    grow: float  # [m] that bodies are inflated by
    margin: float  # [m] to keep from the ground
    ground: bool
    # [m] gap beside inflated meshes that FCL is not asked about; infinite: it always is
    sure: float


class Scratch(NamedTuple):
    """Where the machine's shapes are, and what is left for FCL: memory of one thread."""

    turns: Annotated[Array, "shapes", 3, 3]
    places: Annotated[Array, "shapes", 3]
    around: Annotated[Array, "shapes", 6]  # boxes
    # Shape and obstacle of each pair that is left, for two shapes of the machine (shape, obstacles
    # + other shape); there may be shapes * obstacles + own pairs, and one more.
    pairs: Annotated[Integers, "pairs", 2]
    queue: Annotated[Integers, STACK_SIZE]  # balls that wait
    gaps: Annotated[Array, STACK_SIZE]  # to them, in [m]
    traversal: Traversal
    corners: Annotated[Array, 3, 3]  # of a triangle
    simplex: Annotated[Array, 9, 3]


class CheckerArrays(NamedTuple):
    """All that is known of a machine in its world, for compiled code: one record to hand over."""

    scratch: Scratch
    scene: BroadphaseScene
    grid: MeshGrid
    obstacles: ObstacleArrays
    tree: TriangleTree


def shape_owners(bodies: Sequence[BodyGeometry], cables: Sequence[CableGeometry]) -> list[str]:
    """Return the body's or cable's name of each shape, in the order of ``BroadphaseScene``."""
    solids = [body.name for body in bodies for _ in body.shapes]
    return solids + [cable.name for cable in cables if cable.collides]


def make_broadphase(
    bodies: Sequence[BodyGeometry],
    cables: Sequence[CableGeometry],
    world: World,
    self_pairs: Sequence[tuple[str, str]],
) -> tuple[BroadphaseScene, MeshGrid]:
    """Gather the arrays of ``CheckerArrays``. Nothing is inflated yet.

    Raises:
        UnknownNameError: If ``self_pairs`` names a body or cable that does not exist.
    """
    own_pairs = np.array(_own_pairs(bodies, cables, self_pairs), dtype=np.int64).reshape(-1, 2)
    cables = [cable for cable in cables if cable.collides]
    parts = [(k, body, shape) for k, body in enumerate(bodies) for shape in body.shapes]
    measured = [sizes(shape) for _, _, shape in parts]
    lines = len(cables)
    meshes = [obstacle for obstacle in world.obstacles if obstacle.primitive is None]
    obstacles = obstacle_arrays(world.obstacles)
    paired = np.array([*(body.prescribed for _, body, _ in parts), *[False] * lines], dtype=bool)
    scene = BroadphaseScene(
        kind=np.array(
            [*(int(kind) for kind, _ in measured), *[int(ShapeKind.CAPSULE)] * lines],
            dtype=np.int64,
        ),
        body=np.array([*(k for k, _, _ in parts), *[-1] * lines], dtype=np.int64),
        half=sizes_of(
            [*(half for _, half in measured), *([c.radius, c.radius, 0.0] for c in cables)]
        ),
        own=np.array(
            [*(placement(shape) for _, _, shape in parts), *[np.eye(3, 4)] * lines]
        ).reshape(-1, 3, 4),
        rests=np.array(
            [*(body.touches_ground for _, body, _ in parts), *[True] * lines], dtype=bool
        ),
        obstacle=obstacles.box,
        mesh=obstacles.mesh,
        paired=paired,
        own_pairs=own_pairs,
        kept=np.where(paired[own_pairs].any(axis=1), world.clearance, 0.0),
        grow=0.0,
        margin=0.0,
        ground=world.ground,
        sure=1e-3,  # [m] of a gap beside a mesh: FCL, which errs by a fiftieth of it, is not asked
    )
    return scene, mesh_grid(meshes)


def _own_pairs(
    bodies: Sequence[BodyGeometry],
    cables: Sequence[CableGeometry],
    names: Sequence[tuple[str, str]],
) -> list[tuple[int, int]]:
    """Expand pairs of bodies and cables into pairs of their shapes."""
    parts = [body.name for body in bodies] + [cable.name for cable in cables]
    shapes: dict[str, list[int]] = {part: [] for part in parts}
    for shape, owner in enumerate(shape_owners(bodies, cables)):
        shapes[owner].append(shape)
    for name in (name for pair in names for name in pair if name not in shapes):
        raise UnknownNameError("body", name, known=shapes, where="self-collision pairs")
    return [(a, b) for one, other in names for a in shapes[one] for b in shapes[other]]


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
def grounded(low, rests, margin):  # type: ignore[no-untyped-def]
    """Say whether a shape whose lowest point is at ``low`` is too low for its body."""
    return low < -MAX_PENETRATION if rests else low - margin <= ROUNDING_MARGIN


@kernel
def all_finite(poses):  # type: ignore[no-untyped-def]
    """Say whether no entry of a pose table (bodies, 12) is NaN or infinite."""
    for k in range(poses.shape[0]):
        for j in range(12):
            if not math.isfinite(poses[k, j]):
                return False
    return True


@kernel
def clear_of_meshes(s, arrays):  # type: ignore[no-untyped-def]
    """Say whether it is proved that a placed shape, inflated, is well off all triangles.

    Args:
        s: The shape's row; its box is in the scratch memory.
        arrays: ``CheckerArrays``.
    """
    scratch, scene = arrays.scratch, arrays.scene
    if not math.isfinite(scene.sure):
        return False
    # times as far as its sides do the corners of a box grow out of it, at most
    wanted = 1.7320509 * scene.grow + scene.sure
    shape = Convex(scene.kind[s], scene.half[s], scratch.turns[s], scratch.places[s])
    return mesh_clearance(shape, scratch.around[s], wanted, wanted, arrays.tree, scratch) >= wanted


@kernel
def pairs_of(s, left, arrays):  # type: ignore[no-untyped-def]
    """Append the pairs of a placed shape and obstacles that boxes and gaps leave open.

    Args:
        s: The shape's row.
        left: Pairs so far.
        arrays: ``CheckerArrays``; the pairs in its scratch are written.

    Returns:
        The number of pairs, or COLLIDES where the shape is inside a solid.
    """
    scratch, scene, grid = arrays.scratch, arrays.scene, arrays.grid
    around, pairs, obstacle, mesh = scratch.around, scratch.pairs, scene.obstacle, scene.mesh
    asked, clear, k = False, False, -1
    while True:
        # [m]; boxes that share a point have none
        k = following(k + 1, around[s], 1e-300, arrays.obstacles)
        if k == obstacle.shape[0]:
            return left
        if not overlap(around[s], obstacle[k]):
            continue
        if mesh[k] >= 0:
            if inside(scratch.places[s], mesh[k], grid):
                return COLLIDES
            if not near_surface(around[s], mesh[k], grid):
                continue
            if not asked:
                asked, clear = True, clear_of_meshes(s, arrays)
            if clear:
                continue
        pairs[left, 0], pairs[left, 1] = s, k
        left += 1


@kernel
def broadphase(poses, arrays):  # type: ignore[no-untyped-def]
    """Judge one pose of the machine as far as boxes, the ground and solids decide it.

    Args:
        poses: One row [R | p] per body, shape (bodies, 12).
        arrays: ``CheckerArrays``; its scratch is written, but read where cables are.

    Returns:
        The number of pairs left, or COLLIDES: something is not finite, in the ground, or inside.
    """
    scratch, scene = arrays.scratch, arrays.scene
    turns, places, around, pairs = scratch.turns, scratch.places, scratch.around, scratch.pairs
    kind, body, half, own_pairs = scene.kind, scene.body, scene.half, scene.own_pairs
    obstacle, grow = scene.obstacle, scene.grow
    if not all_finite(poses):
        return COLLIDES
    for s in range(kind.shape[0]):
        if body[s] >= 0:
            place(poses[body[s]], scene.own[s], turns[s], places[s])
        enclose(kind[s], half[s], turns[s], places[s], grow + ROUNDING_MARGIN, around[s])
        if (
            scene.ground
            and body[s] >= 0
            and not scene.paired[s]
            and grounded(around[s, 2] + grow + ROUNDING_MARGIN, scene.rests[s], scene.margin)
        ):
            return COLLIDES
    left = 0
    for s in range(kind.shape[0]):
        if scene.paired[s]:
            continue
        left = pairs_of(s, left, arrays)
        if left == COLLIDES:
            return COLLIDES
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
            return k, COLLIDES
        left = broadphase(poses[k], arrays)
        if left != 0:
            return k, left
    return poses.shape[0], 0


@kernel
def clearance_rows(first, poses, ends, rows, arrays, most, free):  # type: ignore[no-untyped-def]
    """Work out clearances until there is a pose of which only FCL can say whether it is free.

    Args:
        first: Where to begin.
        poses, ends: Of every pose, (poses, bodies, 12) and (poses, cables, 6).
        rows, arrays: As ``broadphase_rows`` takes them.
        most: More clearance than this in [m] is of no interest.
        free: Of each pose in [m], 0 where it collides, shape (poses,); written.

    Returns:
        Which pose it is, the number of poses where there is none; and how many pairs are left.
    """
    scratch = arrays.scratch
    for k in range(first, poses.shape[0]):
        free[k] = 0.0
        if span_all(ends[k], rows, arrays.scene.half, scratch.turns, scratch.places):
            left = broadphase(poses[k], arrays)
            if left > 0:
                return k, left
            if left == 0:
                free[k] = clearance_at(arrays, most)
    return poses.shape[0], 0
