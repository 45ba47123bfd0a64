"""Bounds on the speed of all points of a machine along a motion, by interval arithmetic.

A bound over a box is larger than the largest speed in it, by more the larger the box is. Pieces of
the motion are halved until their bounds are not much larger than the speeds that were sampled, or
until that matters no longer.
"""

from __future__ import annotations

import numpy as np

from kinolab.dynamics.enclosures import Enclosures
from kinolab.numerics.arrays import Array
from kinolab.simulation.motion_pieces import MotionPieces
from kinolab.verification.boxes import MAX_PIECES, boxes

CLOSE = 1.25  # factor on the fastest sample of a step that a bound need not be below
SHORT = 1e-3  # [m] that a piece may be crossed in, whatever its bound


def bounded_speeds(
    enclosures: Enclosures, pieces: MotionPieces, u: Array, sampled: Array
) -> tuple[MotionPieces, Array]:
    """Divide a motion into pieces with a bound on the speed of all points in each.

    Args:
        enclosures: Of the machine.
        pieces: The integrator's steps, a piece each.
        u: Inputs held between the knots, shape (N, nu).
        sampled: The fastest speed of each step that was sampled, in [m/s], shape (steps,).

    Returns:
        The pieces in order, and the bound of each in [m/s], shape (m,).
    """
    bounds = _bounds(enclosures, pieces, u)
    close = CLOSE * sampled
    kept: list[tuple[MotionPieces, Array]] = []
    count = len(bounds)
    while True:
        wide = bounds > close[pieces.step]
        wide &= ~(bounds * (pieces.end - pieces.begin) <= SHORT)
        wide &= pieces.divisible
        count += int(wide.sum())
        if not wide.any() or count > MAX_PIECES:
            break
        kept.append((pieces.part(~wide), bounds[~wide]))
        pieces = pieces.part(wide).halves()
        bounds = _bounds(enclosures, pieces, u)
    for some, known in kept:
        pieces, bounds = pieces.joined(some), np.append(bounds, known)
    order = np.lexsort((pieces.begin, pieces.step))
    return pieces.part(order), bounds[order]


def _bounds(enclosures: Enclosures, pieces: MotionPieces, u: Array) -> Array:
    return np.concatenate([enclosures.speed(box, held) for box, held in boxes(pieces, u)])
