"""Collision constraints: signed distances along a trajectory, with their derivatives."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from functools import lru_cache
from threading import get_ident
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.concurrency.rows import in_parts
from kinolab.numerics.arrays import Array, Integers, allocate
from kinolab.numerics.jit import kernel
from kinolab.numerics.simd import BEFORE_ALL, LANES, bits_of, next_key, ranked
from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.simulation.machine import call_at
from kinolab.trajopt.nlp.path_constraints import LinearInequalities, Samples
from kinolab.world.collision.broadphase import BroadphaseScene, make_broadphase, place
from kinolab.world.distances.gjk import TRIANGLE, Convex, box_gap
from kinolab.world.distances.obstacle_blocks import following
from kinolab.world.distances.placed_shapes import ObstacleArrays, enclose, obstacle_arrays
from kinolab.world.distances.signed_distance import extent, gap_along, highest, signed_gap
from kinolab.world.distances.triangle_gaps import (
    begin_search,
    limit_of,
    next_leaf,
    plane_bound,
    triangle_bounds,
)
from kinolab.world.distances.triangle_tree import Traversal, TriangleTree, mesh_tree
from kinolab.world.obstacles.redundant_obstacles import without_redundant
from kinolab.world.shapes.cable import span
from kinolab.world.shapes.geometry import core_radius_of

# Compiled in; the machine code is rebuilt when this file changes.
FD_STEP = 1e-6  # finite difference of a coordinate, in its unit
MAX_GAPS = 64  # distances kept per pose
TRIANGLES_PER_SHAPE = 4  # nearest triangles kept per shape
SAME_LEVEL = 1e-9  # [m] by which what is behind a plane may be before it
GROUND, OWN = -2, -3  # in place of an obstacle's index


class CollisionArrays(NamedTuple):
    """The machine and its world for compiled kernels."""

    frames: int
    cables: int
    p: Array
    scene: BroadphaseScene
    strung: Integers  # rows of the cables that collide
    fixtures: ObstacleArrays
    tree: TriangleTree
    bodies: int
    strings: int
    coordinates: int
    clearance: float  # [m] required from obstacles


class GapBuffer(NamedTuple):
    """Signed distances of one pose, and scratch memory to find them."""

    mover: Annotated[Integers, MAX_GAPS]  # shape of the machine
    # An obstacle, a triangle (counted after them), GROUND, or OWN - shape.
    what: Annotated[Integers, MAX_GAPS]
    normal: Annotated[Array, MAX_GAPS + 1, 3]  # from the other shape; the last is scratch
    gap: Annotated[Array, MAX_GAPS]  # [m]
    level: Annotated[Array, MAX_GAPS]  # [m] along the normal, of what is nearest of a triangle
    half: Array  # (shapes, 3) half sizes, or more; for cables at their current length
    turns: Annotated[Array, "shapes", 3, 3]
    places: Annotated[Array, "shapes", 3]
    box: Annotated[Array, "shapes", 6]
    poses: Annotated[Array, "bodies", 12]
    ends: Annotated[Array, "cables", 6]
    corners: Annotated[Array, 3, 3]
    scratch: Annotated[Array, 9, 3]
    traversal: Traversal
    room: Array  # (shapes,) [m] that no triangle was nearer, where triangles were looked for last
    seen_turns: Annotated[Array, "shapes", 3, 3]  # there
    seen_places: Annotated[Array, "shapes", 3]
    radius: Array  # (shapes,) [m] of a ball around a centre that holds the core of the shape


class CollisionConstraints:
    """Signed-distance constraints: obstacles, the ground, and self-collision.

    Args:
        clearance: Safety margin of every distance, in [m].
        near: Activation distance of ``rows`` beyond that, as a fraction of half the largest shape.

    Attributes:
        size: Machine size in [m]: geometric mean of half the smallest and half the largest shape.
    """

    begins = False  # distances do not jump with the inputs

    def __init__(self, problem: PlanningTask, clearance: float, near: float = 1.0) -> None:
        model = self._model = problem.model  # keeps the compiled code alive
        self._around, touching = collision_arrays(problem)
        self._clearance, self._near = clearance, near
        shapes = [shape for body in problem.bodies for shape in body.shapes]
        radii = [core_radius_of(shape) for shape in shapes]
        self.size = math.sqrt(min(radii, default=0.0) * max(radii, default=0.0))
        lengths = problem.scales[: model.nq][~problem.circular[: model.nq]]
        self._large, self._farthest = float(lengths.max(initial=1.0)), max(radii, default=0.0)
        self._any = bool(problem.world.obstacles or problem.world.ground or touching)
        self._pace = 0.0  # [s] for each state, when distances were last asked for

    def violation(self, at: Samples) -> float:
        """Return the sum of all violations at samples, in [m]."""
        _, value, _ = self._gaps(at.x, self._clearance, derive=False)
        return float(np.maximum(self._clearance - value, 0.0).sum())

    def rows(self, at: Samples, reach: float) -> LinearInequalities:
        """Linearise the distances that a step may violate, none beyond ``near``.

        Args:
            at: Samples to evaluate at.
            reach: Largest scaled change of any variable.
        """
        nu = at.u.shape[1]
        longest = self._clearance + min(reach * self._large, self._near * self._farthest)
        which, value, slope = self._gaps(at.x, longest)
        return at.rows(which, value - self._clearance, slope, np.zeros((len(which), nu)))

    def free(self, x: Array) -> bool:
        """Say whether all states (m, nx) are collision-free."""
        # 1e-12 [m] signed distance below which shapes touch
        gaps = self._gaps(x, 1e-12, derive=False)[1]  # includes some larger ones
        return bool((gaps >= 1e-12).all())

    def least(self, x: Array) -> float:
        """Return the smallest distance over states (m, nx) in [m], infinite where none is near."""
        return float(np.min(self._gaps(x, self._farthest, derive=False)[1], initial=math.inf))

    def _gaps(
        self, x: Array, reach: float, *, derive: bool = True
    ) -> tuple[NDArray[np.int64], Array, Array]:
        """Return all distances within reach: state indices (n,), distances (n,) in [m], gradients.

        The gradients have shape (n, nx).
        """
        if not self._any:
            return np.zeros(0, np.int64), np.zeros(0), np.zeros((0, x.shape[1]))
        states = np.ascontiguousarray(x)

        def work(rows: slice) -> tuple[NDArray[np.int64], Array, Array]:
            which, value, slope = _found(self._around, states[rows], reach, derive=derive)
            return which + rows.start, value, slope

        begun, count = time.perf_counter(), len(states)
        parts = in_parts(work, count, count * self._pace)
        self._pace = (time.perf_counter() - begun) * len(parts) / max(count, 1)
        which, value, slope = zip(*parts, strict=True)
        return np.concatenate(which), np.concatenate(value), np.concatenate(slope)


def _found(
    around: Record, states: Array, reach: float, *, derive: bool
) -> tuple[NDArray[np.int64], Array, Array]:
    """Return what ``CollisionConstraints._gaps`` does, found by one thread."""
    nx = states.shape[1]
    size = 4 * len(states) + MAX_GAPS
    side, memory = np.zeros(nx), _memory(around, get_ident())
    memory.held.room[:] = -math.inf  # nothing is known of these states yet
    while True:
        which, value = np.zeros(size, np.int64), np.zeros(size)
        slope = np.zeros((size if derive else 1, nx))
        found = find(around, states, reach, int(derive), which, value, slope, side, memory)
        if found <= size - MAX_GAPS:
            return which[:found], value[:found], slope[: found if derive else 0]
        size *= 2


@lru_cache(maxsize=4)
def collision_arrays(problem: PlanningTask) -> tuple[Record, bool]:
    """Return the machine and its world for compiled kernels, and whether self-collision counts.

    Cached: building the bounding volume hierarchy of large meshes can outlast a small program.
    """
    model, bodies, cables = problem.model, problem.bodies, problem.cables
    world = replace(problem.world, obstacles=without_redundant(problem.world.obstacles))
    scene, _ = make_broadphase(bodies, cables, world, problem.machine.collisions)
    record = Record(
        CollisionArrays(
            frames=model.address("frames"),
            cables=model.address("cables"),
            p=np.append(model.parameter_vector(), 0.0),
            scene=scene,
            strung=np.flatnonzero([c.collides for c in cables]).astype(np.int64),
            fixtures=obstacle_arrays(world.obstacles),
            tree=mesh_tree(world.obstacles),
            bodies=len(bodies),
            strings=len(cables),
            coordinates=model.nq,
            clearance=problem.world.clearance,
        )
    )
    return record, len(scene.own_pairs) > 0


@lru_cache(maxsize=16)
def _memory(record: Record, thread: int) -> Record:  # noqa: ARG001  a thread has its own
    """Return scratch memory of a thread for a machine in a world."""
    around = record.held
    shapes = len(around.scene.kind)
    cables, half = max(around.strings, 1), around.scene.half.copy()
    sizes = {"shapes": shapes, "bodies": max(around.bodies, 1), "cables": cables}
    radius, room = np.linalg.norm(half[:, :3], axis=1), np.zeros(shapes)
    return Record(allocate(GapBuffer, sizes, half=half, room=room, radius=radius))


@kernel
def placed(around, x, found):  # type: ignore[no-untyped-def]
    """Place all shapes of the machine at a state ``x``, shape (nx,)."""
    p, scene, strung = around.p.ctypes.data, around.scene, around.strung
    call_at(around.frames, x.ctypes.data, p, found.poses.ctypes.data)
    solid = scene.kind.shape[0] - strung.shape[0]
    for s in range(solid):
        place(found.poses[scene.body[s]], scene.own[s], found.turns[s], found.places[s])
    if strung.shape[0]:
        call_at(around.cables, x.ctypes.data, p, found.ends.ctypes.data)
        for c in range(strung.shape[0]):
            s = solid + c
            span(found.ends[strung[c]], found.half[s], found.turns[s], found.places[s])


@kernel
def gap_of(c, around, found):  # type: ignore[no-untyped-def]
    """Signed distance ``c`` in [m] at the current placement, along its fixed normal."""
    s, k, n = found.mover[c], found.what[c], found.normal[c]
    fixed = around.fixtures
    shape = shape_of(s, around, found)
    if k == GROUND:
        return shape.at[2] - extent(shape, n, -1.0)
    if k <= OWN:
        return gap_along(shape, shape_of(OWN - k, around, found), n)
    if k < fixed.kind.shape[0]:
        return gap_along(shape, obstacle_of(k, fixed), n)
    t = k - fixed.kind.shape[0]
    corners_of(around.tree.triangles[t], found.corners)
    triangle = Convex(TRIANGLE, shape.half, found.corners, shape.at)
    return gap_along(shape, triangle, n) - around.tree.ball[t]


@kernel
def shape_of(s, around, found):  # type: ignore[no-untyped-def]
    """Return a shape of the machine at its current placement."""
    return Convex(around.scene.kind[s], found.half[s], found.turns[s], found.places[s])


@kernel
def obstacle_of(k, fixed):  # type: ignore[no-untyped-def]
    """Return a convex obstacle, one that is not a mesh."""
    return Convex(fixed.kind[k], fixed.half[k], fixed.turn[k], fixed.at[k])


@kernel
def corners_of(triangle, corners):  # type: ignore[no-untyped-def]
    """Write a triangle's corners (9,) as columns (3, 3)."""
    for i in range(9):
        corners[i % 3, i // 3] = triangle[i]


@kernel
def find(around, x, reach, derive, which, value, slope, side, found):  # type: ignore[no-untyped-def]
    """List the distances within reach over all states; return their number.

    Stops and returns ``size`` when fewer than MAX_GAPS entries are left.

    Args:
        around: ``CollisionArrays``.
        x: States, shape (states, nx).
        reach: Largest distance in [m].
        derive: Whether to compute ``slope``.
        which, value: State index and distance in [m] of each, shape (size,); written.
        slope: Gradients of the distances, shape (size, nx); written.
        side: Scratch, shape (nx,).
        found: ``GapBuffer``.
    """
    total = 0
    for m in range(x.shape[0]):
        if total > which.shape[0] - MAX_GAPS:
            return which.shape[0]
        count = find_at(around, x[m], reach + around.clearance, found)
        for c in range(count):
            what, beside = found.what[c], 0.0
            if what >= 0 or (what <= OWN and beside_moving(found.mover[c], OWN - what, around)):
                beside = around.clearance
            which[total + c], value[total + c] = m, found.gap[c] - beside
        if derive and count:
            for i in range(x.shape[1]):
                side[i] = x[m, i]
            for j in range(around.coordinates):
                for sign in (1.0, -1.0):
                    side[j] = x[m, j] + sign * FD_STEP
                    placed(around, side, found)
                    for c in range(count):
                        moved = gap_of(c, around, found)
                        slope[total + c, j] += sign * moved / (2.0 * FD_STEP)
                side[j] = x[m, j]
        total += count
    return total


@kernel
def beside_moving(a, b, around):  # type: ignore[no-untyped-def]
    """Say whether one of two shapes is an obstacle that moves."""
    return around.scene.paired[a] or around.scene.paired[b]


@kernel
def find_at(around, x, reach, found):  # type: ignore[no-untyped-def]
    """Find the distances within reach at one state; return their number."""
    scene = around.scene
    placed(around, x, found)
    count = 0
    for s in range(scene.kind.shape[0]):
        enclose(scene.kind[s], found.half[s], found.turns[s], found.places[s], 0.0, found.box[s])
        if scene.paired[s]:
            continue
        if scene.ground and not scene.rests[s] and count < MAX_GAPS:
            n = found.normal[count]
            n[0], n[1], n[2] = 0.0, 0.0, 1.0
            found.mover[count], found.what[count] = s, GROUND
            found.gap[count] = gap_of(count, around, found)
            count += found.gap[count] < reach
        k = -1
        while True:
            k = following(k + 1, found.box[s], reach, around.fixtures)
            if k == scene.obstacle.shape[0]:
                break
            near = scene.mesh[k] < 0 and box_gap(found.box[s], scene.obstacle[k]) < reach
            if near and count < MAX_GAPS:
                shape, other = shape_of(s, around, found), obstacle_of(k, around.fixtures)
                found.mover[count], found.what[count] = s, k
                found.gap[count] = signed_gap(
                    shape, other, math.inf, found.scratch, found.normal[count]
                )
                count += found.gap[count] < reach
        if around.tree.corners.shape[0] and not still_far(s, reach, found):
            count = near_triangles(s, count, reach, around, found)
    for k in range(scene.own_pairs.shape[0]):
        a, b = scene.own_pairs[k, 0], scene.own_pairs[k, 1]
        if count < MAX_GAPS and box_gap(found.box[a], found.box[b]) < reach:
            found.mover[count], found.what[count] = a, OWN - b
            shape, other = shape_of(a, around, found), shape_of(b, around, found)
            found.gap[count] = signed_gap(
                shape, other, math.inf, found.scratch, found.normal[count]
            )
            count += found.gap[count] < reach
    return count


@kernel
def still_far(s, reach, found):  # type: ignore[no-untyped-def]
    """Say whether a shape has not yet moved near triangles since these were looked for.

    No point of its core has moved by more than its centre and the turn, in the Frobenius norm,
    times its radius; what is round about the core, as a capsule's caps are, moves with that.
    """
    moved = turned = 0.0
    for i in range(3):
        moved += (found.places[s, i] - found.seen_places[s, i]) ** 2
        for j in range(3):
            turned += (found.turns[s, i, j] - found.seen_turns[s, i, j]) ** 2
    return found.room[s] - math.sqrt(moved) - found.radius[s] * math.sqrt(turned) >= reach


@kernel
def near_triangles(s, count, reach, around, found):  # type: ignore[no-untyped-def]
    """Append the triangles nearest to a shape, one per normal direction; return the new count.

    What is behind the plane of one that is kept is left out: it is no nearer, however the shape
    moves along that plane or away from it. Where none is within reach, it is told how far the
    nearest is, so that nearby states need not look again.

    Args:
        s: The shape's row.
        count: Distances so far.
        reach: Largest distance in [m].
        around, found: ``CollisionArrays`` and ``GapBuffer``.
    """
    tree, traversal, n = around.tree, found.traversal, found.normal[MAX_GAPS]
    box, shape = found.box[s], shape_of(s, around, found)
    first, farthest = count, reach
    room = reach + max(reach, found.radius[s])
    slack = begin_search(shape, box, tree, traversal)
    while True:
        worth = farthest if count > first else room
        leaf = next_leaf(limit_of(worth, slack), tree, traversal)
        if leaf < 0:
            break
        if box_behind(tree.leaf_boxes[leaf], first, count, found):
            continue
        near = ranked(triangle_bounds(leaf, tree, traversal.shape))
        key = next_key(near, BEFORE_ALL)
        while key & -LANES < bits_of(limit_of(worth, slack)):
            t = leaf * LANES + (key & (LANES - 1))
            key = next_key(near, key)
            if plane_bound(shape, tree.planes[t]) >= worth:
                continue
            ball = tree.ball[t]
            if triangle_behind(tree.triangles[t], ball, first, count, found):
                continue
            corners_of(tree.triangles[t], found.corners)
            other_shape = Convex(TRIANGLE, found.half[s], found.corners, tree.triangles[t, :3])
            gap = signed_gap(shape, other_shape, worth + ball, found.scratch, n) - ball
            if gap < farthest:
                what, level = t + around.fixtures.kind.shape[0], highest(other_shape, n) + ball
                count = kept(s, what, gap, level, n, first, count, found)
                farthest = farthest_of(first, count, reach, found)
            room = min(room, gap)
            worth = farthest if count > first else room
    remember(s, room if count == first else -math.inf, around, found)
    return count


@kernel
def remember(s, room, around, found):  # type: ignore[no-untyped-def]
    """Keep where a shape is and how far it is from triangles; a cable's length changes."""
    solid = around.scene.kind.shape[0] - around.strung.shape[0]
    found.room[s] = room if s < solid else -math.inf
    for i in range(3):
        found.seen_places[s, i] = found.places[s, i]
        for j in range(3):
            found.seen_turns[s, i, j] = found.turns[s, i, j]


@kernel
def box_behind(box, first, count, found):  # type: ignore[no-untyped-def]
    """Say whether a box (6,) is behind the plane of a distance from ``first`` on."""
    for c in range(first, count):
        n, farthest = found.normal[c], 0.0
        for i in range(3):
            farthest += n[i] * (box[i + 3] if n[i] > 0.0 else box[i])
        if found.gap[c] > 0.0 and farthest <= found.level[c] + SAME_LEVEL:
            return True
    return False


@kernel
def triangle_behind(triangle, ball, first, count, found):  # type: ignore[no-untyped-def]
    """Say the same of a triangle and of what is round about it.

    Args:
        triangle: Corners in [m], shape (9,).
        ball: How far that reaches, in [m].
        first, count: As above.
        found: ``GapBuffer``.
    """
    for c in range(first, count):
        n, farthest = found.normal[c], -math.inf
        for k in range(0, 9, 3):
            corner = n[0] * triangle[k] + n[1] * triangle[k + 1] + n[2] * triangle[k + 2]
            farthest = max(farthest, corner + ball)
        if found.gap[c] > 0.0 and farthest <= found.level[c] + SAME_LEVEL:
            return True
    return False


@kernel
def farthest_of(first, count, reach, found):  # type: ignore[no-untyped-def]
    """Largest distance in [m] at which another triangle would still be kept."""
    if count - first < TRIANGLES_PER_SHAPE:
        return reach
    largest = -math.inf
    for c in range(first, count):
        largest = max(largest, found.gap[c])
    return largest


@kernel
def kept(s, what, gap, level, n, first, count, found):  # type: ignore[no-untyped-def]
    """Insert a triangle, replacing a farther one of like normal or the farthest; return the count.

    Args:
        s, what: The shape's row, and the triangle as in ``GapBuffer.what``.
        gap: Signed distance in [m].
        level: Of the triangle along the normal in [m].
        n: Its unit normal, shape (3,).
        first, count: Index of the shape's first triangle in the list; distances so far.
        found: ``GapBuffer``.
    """
    here = -1
    for c in range(first, count):
        v = found.normal[c]
        # 0.999: cosine between normals above which only the nearer triangle is kept
        if n[0] * v[0] + n[1] * v[1] + n[2] * v[2] > 0.999:
            here = c
    if here < 0 and count - first < TRIANGLES_PER_SHAPE and count < MAX_GAPS:
        here, count = count, count + 1
        found.gap[here] = math.inf
    elif here < 0:
        for c in range(first, count):
            if here < 0 or found.gap[c] > found.gap[here]:
                here = c
    if here >= 0 and gap < found.gap[here]:
        found.gap[here], found.mover[here], found.what[here] = gap, s, what
        found.level[here] = level
        for i in range(3):
            found.normal[here, i] = n[i]
    return count
