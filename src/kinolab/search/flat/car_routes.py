"""Ways of a car: along words of arcs for its trees, and drives along them for its motions."""

from __future__ import annotations

import math

from kinolab.numerics.jit import kernel
from kinolab.numerics.rng import uniform
from kinolab.search.flat.car_drives import (
    REVERSES,
    SLOPE,
    SPEED,
    STEER,
    STEER_SLOPE,
    fit_drive,
)
from kinolab.search.flat.flat_pieces import MOVE, copy_piece, jet, locate_time, total
from kinolab.search.flat.flat_states import is_possible, pose_at
from kinolab.search.flat.line_ramps import CRUISE, put_line
from kinolab.search.flat.piece_sweeps import free_until, is_piece_free
from kinolab.search.tree.flat_arrays import copy
from kinolab.steering.arc_words import shortest_word

SLOWEST, QUICKER, TIMES = 60.0, 1.05, 200  # [s] of steering that is tried first, and quicker ones
LITTLE = 0.01  # of steering from side to side
NO_WAY = 1e-9  # radii
INTERVALS = 4  # of a piece of a drive, at whose ends limits are looked at
STRAIGHT_BEFORE = 0.25  # of drives that are tried begin or end where the motion does


@kernel
def measure_car(search):  # type: ignore[no-untyped-def]
    """Write how fast a car may drive and steer to ``car.pace``, wherever; say whether it can."""
    tight, entry, kept = search.tight, search.flat.entry, search.car.moved
    for i in range(3):
        row = entry[i]
        kept[0, i], kept[1, i] = tight.lower[row], tight.upper[row]
        tight.lower[row], tight.upper[row] = -math.inf, math.inf
    moves = measure_pace(search)
    for i in range(3):
        tight.lower[entry[i]], tight.upper[entry[i]] = kept[0, i], kept[1, i]
    return moves


@kernel
def measure_pace(search):  # type: ignore[no-untyped-def]
    """Write how fast a car may drive and steer at once to ``car.pace``; say whether it can.

    That is what it can along the tightest curves and straight ahead, and steering from side to side
    where it stands.
    """
    pace, flat, draft = search.car.pace, search.flat, search.draft
    begin, end = search.work.begin[:2], search.work.end[:2]
    whole = flat.steering[2] - flat.steering[0]
    slow, quick = least_ramp(search, whole), least_ramp(search, LITTLE * whole)
    if not slow < math.inf or not quick < math.inf:
        return False
    pace[STEER], pace[STEER_SLOPE] = 1.5 * whole / slow, 6.0 * LITTLE * whole / quick**2
    pace[SPEED], pace[SLOPE], pace[REVERSES] = math.inf, math.inf, 1.0
    for gear in (1.0, -1.0):
        for side in range(3):
            draft.size[0] = 0
            # radii of a line on which its full speed is reached
            begin[0], end[0] = 0.0, gear * 1e3 * flat.radius
            begin[1], end[1] = flat.steering[side], flat.steering[side]
            if not put_line(search, draft, MOVE, begin, end):
                if gear > 0.0:
                    return False
                pace[REVERSES] = 0.0
                break
            pace[SPEED] = min(pace[SPEED], fastest_of(draft, 0))
            pace[SLOPE] = min(pace[SLOPE], 2.0 * abs(draft.c[0, 0, 2]))
    return True


@kernel
def least_ramp(search, change):  # type: ignore[no-untyped-def]
    """Return how quickly a car that stands may steer by a change from the right, in [s]."""
    draft, least, T = search.draft, math.inf, SLOWEST
    for _ in range(TIMES):
        put_arc(search, draft, 0, search.start[:3], 0.0, -1)
        draft.duration[0], draft.c[0, 0, 1] = T, 0.0
        draft.c[0, 1, 2], draft.c[0, 1, 3] = 3.0 * change / T**2, -2.0 * change / T**3
        if not is_possible(search, draft, 0, 4 * INTERVALS):
            break
        least, T = T, T / QUICKER
    return least


@kernel
def fastest_of(pieces, axis):  # type: ignore[no-untyped-def]
    """Return how fast an axis changes in the second of some pieces."""
    return abs(pieces.c[CRUISE, axis, 1])


@kernel
def find_word(search, begin, end):  # type: ignore[no-untyped-def]
    """Write the shortest word between two poses (3,); return its length in [m]."""
    reverses = search.car.pace[REVERSES] > 0.0
    return shortest_word(search.car.word, begin, end, search.flat.radius, reverses)


@kernel
def put_arc(search, pieces, k, pose, way, side):  # type: ignore[no-untyped-def]
    """Write the k-th piece: along an arc from a pose (3,), a metre per second.

    Args:
        search, pieces, k: ``FlatSearch``, the pieces, and which of them.
        pose: At its beginning.
        way: In [m], negative backward.
        side: Of the turn: 1, 0, or -1.
    """
    pieces.kind[k], pieces.duration[k], pieces.heading[k] = MOVE, abs(way), 0.0
    for i in range(2):
        for j in range(pieces.c.shape[2]):
            pieces.c[k, i, j] = 0.0
    copy(pose, pieces.pose[k])
    pieces.c[k, 0, 1], pieces.c[k, 1, 0] = math.copysign(1.0, way), search.flat.steering[side + 1]


@kernel
def walk_word(search, pose, aim, forward, reach):  # type: ignore[no-untyped-def]
    """Walk along the word between two poses as far as nothing is touched and it reaches.

    Args:
        search: ``FlatSearch``.
        pose: From where, shape (3,); where it comes to is written.
        aim: The other, shape (3,).
        forward: Whether the word leads from the first to the other; else from there to the first.
        reach: In [m].

    Returns:
        The way gone, and whether that is all.
    """
    word, car, gone = search.car.word, search.car, 0.0
    if forward:
        find_word(search, pose, aim)
    else:
        find_word(search, aim, pose)
    n = word.size[0]
    for i in range(n):
        k = i if forward else n - 1 - i
        way = word.length[k] * search.flat.radius
        if abs(way) <= NO_WAY * search.flat.radius:
            continue
        share = min((reach - gone) / abs(way), 1.0)
        part = share * way if forward else -share * way
        put_arc(search, search.trial, 0, pose, part, int(word.side[k]))
        free = free_until(search, search.trial, 0)
        if free < abs(part):
            kept = max(free, 0.0) * 0.8  # of a free arc that ends at something
            pose_at(search.flat, search.trial, 0, kept, car.pose)
            copy(car.pose, pose)
            return gone + kept, False
        gone += abs(part)
        pose_at(search.flat, search.trial, 0, abs(part), car.pose)
        copy(car.pose, pose)
        if share < 1.0:
            return gone, False
    return gone, True


@kernel
def aim_ahead(search, pose, sample, forward):  # type: ignore[no-untyped-def]
    """Replace a sample (3,) by where the letter from a pose (3,) leads that goes toward its place.

    Words to random poses end in turns, and none leads out of a narrow bay.

    Args:
        search, pose, sample: As ``FlatSearch`` and poses.
        forward: Whether motions go away from that pose.
    """
    flat, car = search.flat, search.car
    dx, dy = sample[0] - pose[0], sample[1] - pose[1]
    c, s = math.cos(pose[2]), math.sin(pose[2])
    x, y = c * dx + s * dy, c * dy - s * dx
    gear = math.copysign(1.0, x) if car.pace[REVERSES] > 0.0 else (1.0 if forward else -1.0)
    bend = 2.0 * y * flat.radius / (x * x + y * y) if x != 0.0 or y != 0.0 else 0.0
    side = 0 if abs(bend) < 0.5 else (1 if bend > 0.0 else -1)
    way = gear * min(math.hypot(x, y), search.reach, flat.radius)
    put_arc(search, search.trial, 0, pose, way, side)
    pose_at(flat, search.trial, 0, abs(way), car.pose)
    copy(car.pose, sample)


@kernel
def is_word_free(search, begin, end):  # type: ignore[no-untyped-def]
    """Say whether nothing is touched along the word between two poses (3,)."""
    copy(begin, search.car.begin)
    _, free = walk_word(search, search.car.begin, end, True, math.inf)
    return free


@kernel
def put_drives(search, count, root):  # type: ignore[no-untyped-def]
    """Write drives between poses in ``corners``, from rest to rest, to ``draft``; say if it can.

    Args:
        search: ``FlatSearch``.
        count: Of the poses.
        root: Of the goal's tree, with whose steering it ends; NONE for any.
    """
    draft, knots, corners = search.draft, search.work.drive, search.corners
    draft.size[0] = 0
    for row in range(1, count):
        last = row + 1 == count and root >= 0
        knots[0, 0], knots[1, 0] = 0.0, 0.0
        knots[0, 1] = search.start[3] if row == 1 else 0.0
        knots[1, 1] = search.goals[root, 3] if last else 0.0
        find_word(search, corners[row - 1], corners[row])
        seconds = fit_drive(search, corners[row - 1], corners[row], knots)
        if seconds < math.inf and is_trial_free(search):
            if draft.size[0] + search.trial.size[0] > draft.kind.shape[0]:
                return False
            for k in range(search.trial.size[0]):
                copy_piece(search.trial, k, draft, draft.size[0])
                draft.size[0] += 1
        elif not put_stops(search, corners[row - 1], corners[row], knots):
            return False
    return True


@kernel
def is_trial_free(search):  # type: ignore[no-untyped-def]
    """Say whether limits allow all pieces in ``trial``, and nothing is touched along them."""
    trial = search.trial
    for k in range(trial.size[0]):
        if not is_possible(search, trial, k, INTERVALS):
            return False
    free, k = True, 0
    while free and k < trial.size[0]:
        free, k = is_piece_free(search, trial, k), k + 1
    return free


@kernel
def put_stops(search, begin, end, knots):  # type: ignore[no-untyped-def]
    """Append what follows the word between two poses, and stops to steer; say whether it can.

    Args:
        search: ``FlatSearch``.
        begin, end: Poses, shape (3,).
        knots: As ``fit_drive`` takes them, at rest.
    """
    word, flat, car = search.car.word, search.flat, search.car
    a, b = search.work.begin[:2], search.work.end[:2]
    find_word(search, begin, end)
    copy(begin, car.pose)
    steer = knots[0, 1]
    for i in range(word.size[0] + 1):
        ends = i == word.size[0]
        way = 0.0 if ends else word.length[i] * flat.radius
        if not ends and abs(way) <= NO_WAY * flat.radius:
            continue
        side = knots[1, 1] if ends else flat.steering[int(word.side[i]) + 1]
        a[0], a[1], b[0], b[1] = 0.0, steer, 0.0, side
        if not put_still(search, a, b):
            return False
        a[1], b[0] = side, way
        if not put_still(search, a, b):
            return False
        steer = side
    return True


@kernel
def put_still(search, a, b):  # type: ignore[no-untyped-def]
    """Append a line of way and steering (2,) from rest to rest; ``car.pose`` goes along."""
    draft, car = search.draft, search.car
    first = draft.size[0]
    if first + 3 > draft.kind.shape[0]:
        return False
    for k in range(3):
        copy(car.pose, draft.pose[first + k])
    if not put_line(search, draft, MOVE, a, b):
        return False
    for k in range(first, draft.size[0]):
        copy(car.pose, draft.pose[k])
        pose_at(search.flat, draft, k, draft.duration[k], car.pose)
    return True


@kernel
def steady_time(search, t):  # type: ignore[no-untyped-def]
    """Return the last time of ``draft`` up to t at which its steering does not turn, in [s]."""
    draft, slow = search.draft, NO_WAY * search.car.pace[STEER]
    k, since = locate_time(draft, t)
    _, rate, _, _ = jet(draft.c[k, 1], since)
    while abs(rate) > slow and t > 0.0:
        t -= since
        if abs(draft.c[k, 1, 1]) <= slow or k == 0:
            return t
        k -= 1
        since = draft.duration[k]
        _, rate, _, _ = jet(draft.c[k, 1], since)
    return t


@kernel
def try_drive(search):  # type: ignore[no-untyped-def]
    """Put a drive between two times of ``draft`` into ``trial``; return both, and if it is shorter.

    None begins or ends while its steering turns, but before that.
    """
    knots, car = search.work.drive, search.car
    draft = search.draft
    whole = total(draft)
    a, b = whole * uniform(search.random), whole * uniform(search.random)
    begin, end = min(a, b), max(a, b)
    if uniform(search.random) < STRAIGHT_BEFORE:
        begin = 0.0
    if uniform(search.random) < STRAIGHT_BEFORE:
        end = whole
    begin, end = steady_time(search, begin), steady_time(search, end)
    for row in range(2):
        k, t = locate_time(draft, begin if row == 0 else end)
        _, knots[row, 0], _, _ = jet(draft.c[k, 0], t)
        knots[row, 1], _, _, _ = jet(draft.c[k, 1], t)
        if abs(knots[row, 0]) <= NO_WAY * car.pace[SPEED]:
            knots[row, 0] = 0.0
        pose_at(search.flat, draft, k, t, car.begin if row == 0 else car.end)
    find_word(search, car.begin, car.end)
    T = fit_drive(search, car.begin, car.end, knots)
    # 2 % of the duration of what a drive replaces are to be gained
    shorter = end > begin and 0.98 * (end - begin) > T
    return begin, end, shorter and is_trial_free(search)
