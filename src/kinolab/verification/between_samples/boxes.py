"""What may happen between samples: quantities over boxes that contain whole pieces of a motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.intervals import IntervalArray
from kinolab.simulation.motion_pieces import MotionPieces

MAX_PIECES = 200_000  # that are halved before a motion counts as too wild to be checked
PIECES_PER_BATCH = 4000
# Of a step of the integrator, into parts of 1e-12. What has no bound even there, such as the
# quotient of two numbers that pass zero together, is judged by what it is at both ends.
MAX_HALVINGS = 40

# boxes (m, nx), held inputs (m, nu) -> by how much limits are passed at most, (m, limits)
MostExcess = Callable[[IntervalArray, Array], Array]


def boxes(pieces: MotionPieces, u: Array) -> Iterator[tuple[IntervalArray, Array]]:
    """Yield batches of boxes of states (m, nx) and inputs that are held in them (m, nu).

    Args:
        pieces: Of the motion.
        u: Inputs held between the knots, shape (N, nu).
    """
    for first in range(0, len(pieces.begin), PIECES_PER_BATCH):
        some = pieces.part(np.arange(first, min(first + PIECES_PER_BATCH, len(pieces.begin))))
        with np.errstate(all="ignore"):  # infinite where a box is too wide
            yield some.box, u[some.knots]


def hidden_excess(
    pieces: MotionPieces, u: Array, most: MostExcess, at_ends: Callable[[MotionPieces], Array]
) -> tuple[float, float, int] | None:
    """Return where a limit may be passed that no sample passes, after halving all pieces there.

    Args:
        pieces: Of the motion.
        u: Inputs held between the knots, shape (N, nu).
        most: Says by how much limits are passed at most within boxes, more than samples vouch for.
        at_ends: Says by how much they are passed at the ends of pieces at most, shape (m, limits).

    Returns:
        Time in [s], by how much at most, and which limit; None if none is passed.
    """
    halved = 0
    # 256 pieces take little longer than one: calls of NumPy are what takes time
    while 0 < len(pieces.begin) <= 128 and pieces.divisible.all():
        pieces = pieces.halves()
    for _ in range(MAX_HALVINGS):
        if not len(pieces.begin):
            return None
        passed = _most(pieces, u, most)
        pieces, passed = _left(pieces, passed)
        if (sure := at_ends(pieces)).max(initial=0.0) > 0.0:
            return _worst(pieces, sure)
        last = ~pieces.divisible
        if last.any() and (found := _judged(pieces.part(last), passed[last], at_ends)):
            return found
        halved += len(pieces.begin)
        if halved > MAX_PIECES:
            return _worst(pieces, passed)
        pieces = pieces.part(~last).halves()
    return _judged(pieces, _most(pieces, u, most), at_ends)


def _left(pieces: MotionPieces, passed: Array) -> tuple[MotionPieces, Array]:
    """Return the pieces in which a limit may be passed, and by how much."""
    rows = np.flatnonzero(np.any(~(passed <= 0.0), axis=1))
    return pieces.part(rows), passed[rows]


def _judged(
    pieces: MotionPieces, passed: Array, at_ends: Callable[[MotionPieces], Array]
) -> tuple[float, float, int] | None:
    """Return where a limit is passed in the shortest pieces; without a bound, at their ends."""
    pieces, passed = _left(pieces, np.where(np.isfinite(passed), passed, at_ends(pieces)))
    return _worst(pieces, passed) if len(passed) else None


def _most(pieces: MotionPieces, u: Array, most: MostExcess) -> Array:
    return np.concatenate([most(box, held) for box, held in boxes(pieces, u)])


def _worst(pieces: MotionPieces, passed: Array) -> tuple[float, float, int]:
    over = np.where(np.isnan(passed), np.inf, passed)
    k, i = map(int, np.unravel_index(int(over.argmax()), over.shape))
    return float(pieces.begin[k]), float(over[k, i]), i
