"""Cables as capsules between two moving points."""

from __future__ import annotations

import math

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel

NO_ENDS: Array = np.zeros((0, 6))  # of a machine without cables


@kernel
def finite(ends):  # type: ignore[no-untyped-def]
    """Say whether both ends (6,) of a cable are finite."""
    sound = True
    for j in range(6):
        sound = sound and math.isfinite(ends[j])
    return sound


@kernel
def complete(x, y, z, turn):  # type: ignore[no-untyped-def]
    """Write a rotation (3, 3) whose third column is the unit vector x, y, z.

    Source: Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017.
    """
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    turn[0, 0], turn[1, 0], turn[2, 0] = 1.0 + sign * x * x * a, sign * b, -sign * x
    turn[0, 1], turn[1, 1], turn[2, 1] = b, sign + y * y * a, -y
    turn[0, 2], turn[1, 2], turn[2, 2] = x, y, z


@kernel
def span(ends, half, turn, at):  # type: ignore[no-untyped-def]
    """Place a capsule between two points (6,): set half[2], the turn (3, 3) and the centre (3,)."""
    largest = 0.0
    for i in range(3):
        at[i] = 0.5 * ends[i] + 0.5 * ends[i + 3]
        largest = max(largest, abs(0.5 * ends[i + 3] - 0.5 * ends[i]))
    x, y, z = 0.0, 0.0, 1.0  # ends that coincide make a ball, which has no direction
    half[2] = 0.0
    if largest > 0.0:  # divided by it so that no square overflows
        x = (0.5 * ends[3] - 0.5 * ends[0]) / largest
        y = (0.5 * ends[4] - 0.5 * ends[1]) / largest
        z = (0.5 * ends[5] - 0.5 * ends[2]) / largest
        length = math.sqrt(x * x + y * y + z * z)
        half[2] = largest * length
        x, y, z = x / length, y / length, z / length
    complete(x, y, z, turn)


@kernel
def span_all(ends, rows, half, turns, places):  # type: ignore[no-untyped-def]
    """Place the capsules of several cables, which are the last shapes of the machine.

    Args:
        ends: Of all cables, shape (cables, 6).
        rows: Which of them have a shape, shape (shapes of cables,).
        half, turns, places: Of all shapes, (shapes, 3), (shapes, 3, 3), (shapes, 3); written.

    Returns:
        Whether all of them are finite; the others are not placed.
    """
    sound, first = True, half.shape[0] - rows.shape[0]
    for c in range(rows.shape[0]):
        if finite(ends[rows[c]]):
            span(ends[rows[c]], half[first + c], turns[first + c], places[first + c])
        else:
            sound = False
    return sound
