"""What may happen between samples: quantities over boxes that contain whole pieces of a motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.intervals import IntervalArray
from kinolab.simulation.motion_pieces import MotionPieces

MAX_PIECES = 200_000  # that a motion is divided into before it counts as too wild to be checked
PIECES_PER_BATCH = 4000

MostExcess = Callable[
    [IntervalArray, Array], Array
]  # boxes (m, nx), held inputs (m, nu) -> (m, limits)


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
    pieces: MotionPieces, u: Array, most: MostExcess, slack: Array
) -> tuple[float, float, int] | None:
    """Return where a limit may be passed that no sample passes, after halving all pieces there.

    Args:
        pieces: Of the motion.
        u: Inputs held between the knots, shape (N, nu).
        most: Says by how much limits are passed at most within boxes.
        slack: By how much each may be passed, shape (limits,): samples vouch for that.

    Returns:
        Time in [s], by how much at most, and which limit; None if none is passed by more.
    """
    count = len(pieces.begin)
    while len(pieces.begin):
        passed = np.concatenate([most(box, held) for box, held in boxes(pieces, u)])
        open_ = np.any(~(passed <= slack), axis=1)
        count += int(open_.sum())
        if count > MAX_PIECES or (open_ & ~pieces.divisible).any():
            over = np.where(np.isnan(passed), np.inf, passed - slack)
            k, i = map(int, np.unravel_index(int(over.argmax()), over.shape))
            return float(pieces.begin[k]), float(passed[k, i]), i
        pieces = pieces.part(open_).halves()
    return None
