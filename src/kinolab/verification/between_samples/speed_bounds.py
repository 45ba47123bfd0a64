"""Bounds on the speed of all points of a machine along a motion, by interval arithmetic.

A bound over a box is larger than the largest speed in it, by more the larger the box is. Pieces of
the motion are halved until their bounds are not much larger than the speeds that were sampled, or
until that matters no longer.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kinolab.dynamics.model.enclosures import Enclosures
from kinolab.numerics.arrays import Array
from kinolab.simulation.motion_pieces import MotionPieces
from kinolab.verification.between_samples.boxes import MAX_HALVINGS, MAX_PIECES, boxes

SHORT, LONG = 1e-3, 100.0  # [m] of a piece that is short enough whatever its bound, and too long


def bounded_speeds(
    enclosures: Enclosures,
    pieces: MotionPieces,
    u: Array,
    sampled: Array,
    moved: Callable[[MotionPieces], Array],
) -> tuple[MotionPieces, Array]:
    """Divide a motion into pieces with a bound on the speed of all points in each.

    Args:
        pieces: The integrator's steps, a piece each.
        u: Inputs held between the knots, shape (N, nu).
        sampled: The fastest speed of each step that was sampled, in [m/s], shape (steps,).
        moved: Says how far points are moved from one end of pieces to the other, in [m], (m,).

    Returns:
        The pieces in order, and the bound of each in [m/s], shape (m,).
    """
    bounds = _bounds(enclosures, pieces, u)
    close = 1.25 * sampled  # factor on the fastest sample of a step that a bound need not be below
    kept: list[tuple[MotionPieces, Array]] = []
    halved = 0
    for _ in range(MAX_HALVINGS):
        way = bounds * (pieces.end - pieces.begin)
        wide = (bounds > close[pieces.step]) & ~(way <= SHORT) | (way > LONG)
        wide &= pieces.divisible
        halved += int(wide.sum())
        if not wide.any() or halved > MAX_PIECES:
            break
        kept.append((pieces.part(~wide), bounds[~wide]))
        pieces = pieces.part(wide).halves()
        bounds = _bounds(enclosures, pieces, u)
    else:  # in 1e-12 of a step
        usual = close[pieces.step]
        # [m] between the ends of the shortest pieces, which rounding does not explain
        jumps = ~(moved(pieces) <= usual * (pieces.end - pieces.begin) + 1e-8)
        bounds = np.where(np.isfinite(bounds) | jumps, bounds, usual)
    kept = [(pieces, bounds), *kept]
    pieces = MotionPieces.joined([some for some, _ in kept])
    bounds = np.concatenate([known for _, known in kept])
    order = np.lexsort((pieces.begin, pieces.step))
    return pieces.part(order), bounds[order]


def _bounds(enclosures: Enclosures, pieces: MotionPieces, u: Array) -> Array:
    return np.concatenate([enclosures.speed(box, held) for box, held in boxes(pieces, u)])
