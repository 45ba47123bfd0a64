"""Shorter motions: between two states of one, polynomials that go from the one to the other.

Source: Hauser, Ng-Thow-Hing, Fast smoothing of manipulator trajectories using optimal
bounded-acceleration shortcuts, ICRA 2010.
"""

from __future__ import annotations

import math

from kinolab.numerics.jit import kernel
from kinolab.numerics.rng import uniform
from kinolab.search.flat.car_routes import try_drive
from kinolab.search.flat.flat_machine import CAR, PLANE
from kinolab.search.flat.flat_pieces import (
    MOVE,
    TURN,
    begin_later,
    copy_piece,
    fit_cubic,
    fit_quintic,
    jet,
    locate_time,
    total,
)
from kinolab.search.flat.flat_states import SLOW, is_possible, pose_at
from kinolab.search.flat.piece_sweeps import is_piece_free

LONGER, DURATIONS = 1.2, 16  # durations that are tried, each so many times the one before
BEGIN, END, MIDDLE = 0, 1, 2  # rows of ``work.knots``


@kernel
def shorten_pieces(search, attempts):  # type: ignore[no-untyped-def]
    """Try shortcuts of ``draft``; return how many were made.

    Every fourth one leads through a state beside the motion: where a motion clings to a corner,
    straight ones touch it.
    """
    made, most = 0, search.draft.kind.shape[0]
    for k in range(attempts):
        if search.flat.kind == CAR:
            begin, end, shorter = try_drive(search)
            if shorter and search.draft.size[0] + search.trial.size[0] + 1 <= most:
                i, t = locate_time(search.draft, begin)
                j, later = locate_time(search.draft, end)
                splice(search, i, t, j, later, search.trial.size[0])
                made += 1
            continue
        whole = total(search.draft)
        a, b = whole * uniform(search.random), whole * uniform(search.random)
        if try_shortcut(search, min(a, b), max(a, b), 1 if k % 4 == 3 else 0):
            made += 1
    return made


@kernel
def try_shortcut(search, begin, end, between):  # type: ignore[no-untyped-def]
    """Replace what is between two times of ``draft`` if that takes less time; say whether it did.

    Args:
        search: ``FlatSearch``.
        begin, end: Times since the beginning in [s].
        between: How many states it leads through, 0 or 1.
    """
    draft, trial, knots = search.draft, search.trial, search.work.knots
    if draft.size[0] + 3 > draft.kind.shape[0]:
        return False
    i, t = locate_time(draft, begin)
    j, later = locate_time(draft, end)
    if not read_knot(search, i, t, knots[BEGIN]) or not read_knot(search, j, later, knots[END]):
        return False
    # 2 % of the duration of what a shortcut replaces are to be gained
    longest = 0.98 * (end - begin)
    if between:
        k, middle = locate_time(draft, begin + uniform(search.random) * (end - begin))
        read_knot(search, k, middle, knots[MIDDLE])
        lead_aside(search)
        first = join(search, 0, BEGIN, MIDDLE, longest)
        found = first < longest and join(search, 1, MIDDLE, END, longest - first) < math.inf
    else:
        found = join(search, 0, BEGIN, END, longest) < math.inf
    for k in range(1 + between):
        found = found and is_piece_free(search, trial, k)
    if found:
        splice(search, i, t, j, later, 1 + between)
    return found


@kernel
def read_knot(search, k, t, knot):  # type: ignore[no-untyped-def]
    """Write values, slopes and second derivatives (outputs, 3) at a time of a piece of ``draft``.

    Return whether a shortcut may begin or end there: where a machine that drives along curves
    stands still, it has no direction.
    """
    draft = search.draft
    for r in range(knot.shape[0]):
        knot[r, 0], knot[r, 1], knot[r, 2], _ = jet(draft.c[k, r], t)
    if search.flat.kind != PLANE:
        return True
    return draft.kind[k] != TURN and math.hypot(knot[0, 1], knot[1, 1]) > 1e3 * SLOW


@kernel
def lead_aside(search):  # type: ignore[no-untyped-def]
    """Move the middle state aside, and let it go in the direction between those of both ends."""
    knots, length = search.work.knots, 0.0
    for r in range(knots.shape[1]):
        length += (search.flat.weight[r] * (knots[END, r, 0] - knots[BEGIN, r, 0])) ** 2
    # of the way between its ends, by which a shortcut may lead aside
    reach, share = 0.25 * math.sqrt(length), uniform(search.random)
    for r in range(knots.shape[1]):
        off = (2.0 * uniform(search.random) - 1.0) * reach / search.flat.weight[r]
        knots[MIDDLE, r, 0] += off
        knots[MIDDLE, r, 1] = share * (knots[BEGIN, r, 1] + knots[END, r, 1])
        knots[MIDDLE, r, 2] = 0.0


@kernel
def join(search, k, begin, end, longest):  # type: ignore[no-untyped-def]
    """Write the quickest polynomials between two knots to ``trial``; return their duration in [s].

    It is infinite where none is possible that takes no longer than ``longest``.

    Args:
        search: ``FlatSearch``.
        k: Of the pieces in ``trial``.
        begin, end: Rows of ``work.knots``.
        longest: In [s].
    """
    before = least_seconds(search, begin, end)
    # intervals of a polynomial, at whose ends limits are looked at, at least
    T, samples = max(before, longest / LONGER**DURATIONS), 8
    while search.flat.kind == PLANE and samples * search.step < longest:
        samples *= 2  # a curve may turn sharply where it is slow
    while not is_join_possible(search, k, begin, end, T, samples):
        if not longest > T:
            return math.inf
        before, T = T, min(LONGER * T, longest)
    for _ in range(2):  # bisections of the first that is possible
        middle = 0.5 * (before + T)
        if is_join_possible(search, k, begin, end, middle, samples):
            T = middle
        else:
            before = middle
    possible = is_join_possible(search, k, begin, end, T, samples)
    return T if possible and not turns_back(search, k, samples) else math.inf


@kernel
def least_seconds(search, begin, end):  # type: ignore[no-untyped-def]
    """Return what the way between two knots takes at full speed in [s]; 0 where none is known."""
    a, b, least = search.work.knots[begin], search.work.knots[end], 0.0
    for r in range(a.shape[0] if search.flat.timed else 0):
        least = max(least, search.flat.weight[r] * abs(b[r, 0] - a[r, 0]))
    return least


@kernel
def is_join_possible(search, k, begin, end, T, samples):  # type: ignore[no-untyped-def]
    """Write polynomials of a duration between two knots to ``trial``; say if limits allow it.

    Args:
        search, k, begin, end: As ``join`` takes them.
        T: The duration in [s].
        samples: As ``is_possible`` takes them.
    """
    trial, a, b = search.trial, search.work.knots[begin], search.work.knots[end]
    trial.kind[k], trial.duration[k], trial.heading[k] = MOVE, T, 0.0
    for r in range(a.shape[0]):
        c = trial.c[k, r]
        if search.flat.kind == PLANE:
            fit_quintic(c, T, a[r, 0], a[r, 1], a[r, 2], b[r, 0], b[r, 1], b[r, 2])
        else:
            fit_cubic(c, T, a[r, 0], a[r, 1], b[r, 0], b[r, 1])
    return is_possible(search, trial, k, samples)


@kernel
def turns_back(search, k, samples):  # type: ignore[no-untyped-def]
    """Say whether a curve in ``trial`` turns by more than a right angle between two samples."""
    if search.flat.kind != PLANE:
        return False
    trial, bx, by = search.trial, 0.0, 0.0
    for m in range(samples + 1):
        t = trial.duration[k] * m / samples
        _, vx, _, _ = jet(trial.c[k, 0], t)
        _, vy, _, _ = jet(trial.c[k, 1], t)
        if m > 0 and not vx * bx + vy * by > 0.0:
            return True
        bx, by = vx, vy
    return False


@kernel
def splice(search, i, t, j, later, count):  # type: ignore[no-untyped-def]
    """Put ``trial`` between a time of the i-th piece of ``draft`` and one of the j-th.

    Args:
        search: ``FlatSearch``.
        i, t, j, later: Both pieces, and times in them.
        count: Of the pieces in ``trial``.
    """
    draft, spare = search.draft, search.spare
    spare.size[0] = 0
    for k in range(i + 1):
        append(draft, k, spare)
    spare.duration[i] = t
    for k in range(count):
        append(search.trial, k, spare)
    m = spare.size[0]
    for k in range(j, draft.size[0]):
        append(draft, k, spare)
    spare.duration[m] -= later
    if search.flat.kind == CAR:
        pose_at(search.flat, draft, j, later, spare.pose[m])
    for r in range(spare.c.shape[1]):
        begin_later(spare.c[m, r], later)
    draft.size[0] = 0
    for k in range(spare.size[0]):
        if spare.duration[k] > 0.0:
            append(spare, k, draft)


@kernel
def append(source, k, target):  # type: ignore[no-untyped-def]
    """Append the k-th of some pieces to others."""
    copy_piece(source, k, target, target.size[0])
    target.size[0] += 1
