"""Shorter motions: between two states of one, polynomials that go from the one to the other.

Source: Hauser, Ng-Thow-Hing, Fast smoothing of manipulator trajectories using optimal
bounded-acceleration shortcuts, ICRA 2010.
"""

from __future__ import annotations

import math

from kinolab.numerics.jit import kernel
from kinolab.numerics.rng import uniform
from kinolab.search.flat.flat_machine import PLANE
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
from kinolab.search.flat.flat_states import SLOW, is_possible
from kinolab.search.flat.piece_sweeps import is_piece_free
from kinolab.steering.path_motion import ROUNDING_FACTOR

SAMPLES = 8  # intervals of a shortcut, at whose ends limits are looked at
LONGER, DURATIONS = 1.2, 16  # durations that are tried, each so many times the one before
BISECTIONS = 2  # of the first that is possible
LEAST_GAIN = 0.02  # of the duration of what it replaces


@kernel
def shorten_pieces(search, attempts):  # type: ignore[no-untyped-def]
    """Try shortcuts of ``draft``; return how many were made."""
    made = 0
    for _ in range(attempts):
        whole = total(search.draft)
        a, b = whole * uniform(search.random), whole * uniform(search.random)
        if try_shortcut(search, min(a, b), max(a, b)):
            made += 1
    return made


@kernel
def try_shortcut(search, begin, end):  # type: ignore[no-untyped-def]
    """Replace what is between two times of ``draft`` if that takes less time; say whether it did.

    Args:
        search: ``FlatSearch``.
        begin, end: Times since the beginning in [s].
    """
    draft, trial = search.draft, search.trial
    if draft.size[0] + 2 > draft.kind.shape[0]:
        return False
    i, t = locate_time(draft, begin)
    j, later = locate_time(draft, end)
    longest = (1.0 - LEAST_GAIN) * (end - begin)
    if draft.kind[i] == TURN or draft.kind[j] == TURN or not longest > search.step:
        return False
    if not fit_shortcut(search, i, t, j, later, longest):
        return False
    samples = SAMPLES
    while search.flat.kind == PLANE and samples * search.step < longest:
        samples *= 2  # a curve may turn sharply where it is slow
    low, high = 0.0, longest / LONGER**DURATIONS
    while True:
        fit_shortcut(search, i, t, j, later, high)
        if is_possible(search, trial, 0, samples):
            break
        low, high = high, LONGER * high
        if high > longest * ROUNDING_FACTOR:
            return False
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        fit_shortcut(search, i, t, j, later, middle)
        if is_possible(search, trial, 0, samples):
            high = middle
        else:
            low = middle
    fit_shortcut(search, i, t, j, later, high)
    if turns_back(search, samples) or not is_piece_free(search, trial, 0):
        return False
    splice(search, i, t, j, later)
    return True


@kernel
def fit_shortcut(search, i, t, j, later, T):  # type: ignore[no-untyped-def]
    """Write the polynomials of a shortcut to ``trial``; say whether there are any.

    There are none where a machine that drives along curves stands still at an end.

    Args:
        search: ``FlatSearch``.
        i, t: Piece and time in it where it begins.
        j, later: Where it ends.
        T: Its duration in [s].
    """
    draft, trial, plane = search.draft, search.trial, search.flat.kind == PLANE
    trial.kind[0], trial.duration[0], trial.heading[0] = MOVE, T, draft.heading[i]
    for r in range(search.corners.shape[1]):
        z0, v0, a0, _ = jet(draft.c[i, r], t)
        z1, v1, a1, _ = jet(draft.c[j, r], later)
        if plane:
            fit_quintic(trial.c[0, r], T, z0, v0, a0, z1, v1, a1)
        else:
            fit_cubic(trial.c[0, r], T, z0, v0, z1, v1)
    return not plane or not (is_slow(draft, i, t) or is_slow(draft, j, later))


@kernel
def turns_back(search, samples):  # type: ignore[no-untyped-def]
    """Say whether a curve in ``trial`` turns by more than a right angle between two samples."""
    if search.flat.kind != PLANE:
        return False
    trial, bx, by = search.trial, 0.0, 0.0
    for m in range(samples + 1):
        t = trial.duration[0] * m / samples
        _, vx, _, _ = jet(trial.c[0, 0], t)
        _, vy, _, _ = jet(trial.c[0, 1], t)
        if m > 0 and not vx * bx + vy * by > 0.0:
            return True
        bx, by = vx, vy
    return False


@kernel
def is_slow(pieces, k, t):  # type: ignore[no-untyped-def]
    """Say whether a point stands still, as good as, at a time of a piece."""
    _, vx, _, _ = jet(pieces.c[k, 0], t)
    _, vy, _, _ = jet(pieces.c[k, 1], t)
    return math.hypot(vx, vy) <= 1e3 * SLOW


@kernel
def splice(search, i, t, j, later):  # type: ignore[no-untyped-def]
    """Put ``trial`` between a time of the i-th piece of ``draft`` and one of the j-th."""
    draft, spare = search.draft, search.spare
    spare.size[0] = 0
    for k in range(i + 1):
        append(draft, k, spare)
    spare.duration[i] = t
    append(search.trial, 0, spare)
    m = spare.size[0]
    for k in range(j, draft.size[0]):
        append(draft, k, spare)
    spare.duration[m] -= later
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
