"""From linked trees to a motion: fewer corners, and what is between them in time."""

from __future__ import annotations

import math

from kinolab.numerics.jit import kernel
from kinolab.problem.goal_kernel import wrapped_angle
from kinolab.search.flat.car_routes import is_word_free, put_drives
from kinolab.search.flat.flat_machine import CAR, PLANE
from kinolab.search.flat.flat_pieces import MOVE, TURN, put_stretch
from kinolab.search.flat.flat_trees import NONE, gap
from kinolab.search.flat.line_ramps import put_line
from kinolab.search.flat.piece_sweeps import free_until, is_piece_free
from kinolab.search.tree.flat_arrays import copy


@kernel
def gather_corners(search, node, other):  # type: ignore[no-untyped-def]
    """Write the corners of the way through both trees; return how many, and the root in the goal.

    Args:
        search: ``FlatSearch``; its ``corners`` are written.
        node, other: Of the tree from the start, and of that from the goal, which is at the same
            place; NONE where the way ends in the first.
    """
    ahead, behind, corners = search.ahead, search.behind, search.corners
    count, k = 0, node
    while k != NONE:
        count += 1
        k = ahead.parent[k]
    if count > corners.shape[0]:
        return 0, NONE
    k = node
    for row in range(count - 1, -1, -1):
        copy(ahead.z[k], corners[row])
        k = ahead.parent[k]
    root, k = NONE, other
    while k != NONE:
        root, k = k, behind.parent[k]
        if k != NONE:
            if count == corners.shape[0]:
                return 0, NONE
            copy(behind.z[k], corners[count])
            count += 1
    for row in range(1, count):
        for i in range(corners.shape[1]):
            corners[row, i] = corners[row - 1, i] + gap(search, corners[row - 1], corners[row], i)
    return count, root


@kernel
def is_line_free(search, a, b):  # type: ignore[no-untyped-def]
    """Say whether the straight line between two corners touches nothing."""
    z, way, corners = search.work.z, search.work.direction, search.corners
    if search.flat.kind == CAR:
        return is_word_free(search, corners[a], corners[b])
    for i in range(z.shape[0]):
        z[i], way[i] = 0.0, 0.0
    for i in range(corners.shape[1]):
        z[i], way[i] = corners[a, i], corners[b, i] - corners[a, i]
    put_stretch(search.trial, 0, MOVE, z, way, 0.0, 1.0, 0.0, 1.0)
    return is_piece_free(search, search.trial, 0)


@kernel
def prune_corners(search, count):  # type: ignore[no-untyped-def]
    """Leave out corners from each of which a later one is seen; return how many are left."""
    corners, kept, at = search.corners, 1, 0
    while at < count - 1:
        seen = at + 1
        for later in range(count - 1, at + 1, -1):
            if is_line_free(search, at, later):
                seen = later
                break
        copy(corners[seen], corners[kept])
        at, kept = seen, kept + 1
    return kept


@kernel
def put_route(search, count, root):  # type: ignore[no-untyped-def]
    """Write the motion along corners, from rest to rest, to ``draft``; say whether there is one.

    Args:
        search: ``FlatSearch``.
        count: Of the corners.
        root: Of the goal's tree, whose heading the machine ends with; NONE for any.
    """
    if search.flat.kind == CAR:
        return put_drives(search, count, root)
    draft, corners, outputs = search.draft, search.corners, search.corners.shape[1]
    begin, end = search.work.begin, search.work.end
    draft.size[0] = 0
    for i in range(begin.shape[0]):
        begin[i] = search.start[i]
    plane = search.flat.kind == PLANE
    for row in range(1, count):
        for i in range(outputs):
            begin[i], end[i] = corners[row - 1, i], corners[row, i]
        if plane:
            dx, dy = end[0] - begin[0], end[1] - begin[1]
            if dx == 0.0 and dy == 0.0:
                continue
            if not put_turn(search, begin, math.atan2(dy, dx)):
                return False
            end[2] = begin[2]
        if not put_line(search, draft, MOVE, begin, end):
            return False
    for i in range(outputs):
        begin[i] = corners[count - 1, i]
    if plane and root != NONE and search.heads:
        return put_turn(search, begin, search.goals[root, 2])
    return True


@kernel
def put_turn(search, begin, heading):  # type: ignore[no-untyped-def]
    """Append a turn on the spot, the shorter way round if nothing is touched; say whether it can.

    Args:
        search: ``FlatSearch``.
        begin: The pose, shape (3,); its heading becomes the new one.
        heading: In [rad].
    """
    draft, last = search.draft, search.work.last
    away = wrapped_angle(heading - begin[2])
    if abs(away) <= 1e-9:  # [rad] of a turn that is none
        return True
    first = draft.size[0]
    for turn in (away, away - math.copysign(2.0 * math.pi, away)):
        last[0], last[1], last[2] = begin[0], begin[1], begin[2] + turn
        draft.size[0] = first
        if not put_line(search, draft, TURN, begin, last):
            return False
        free = True
        for k in range(first, draft.size[0]):
            free = free and free_until(search, draft, k) >= draft.duration[k]
        if free:
            begin[2] = last[2]
            return True
    return False
