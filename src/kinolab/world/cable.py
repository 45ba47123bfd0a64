"""Cables as capsules between two moving points."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from kinolab.world.geometry import Array

NO_ENDS: Array = np.zeros((0, 6))  # of a machine without cables


@dataclass(frozen=True)
class CableGeometry:
    """What the world sees of one cable; its ends come with every pose.

    One that does not collide keeps its row among the ends.
    """

    name: str
    radius: float  # [m]
    collides: bool = True


@numba.njit(cache=True, error_model="numpy")
def finite(ends):  # type: ignore[no-untyped-def]
    """Say whether both ends (6,) of a cable are finite."""
    sound = True
    for j in range(6):
        sound = sound and math.isfinite(ends[j])
    return sound


@numba.njit(cache=True, error_model="numpy")
def complete(n, turn):  # type: ignore[no-untyped-def]
    """Write a rotation (3, 3) whose third column is the unit vector n (3,).

    Source: Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017.
    """
    sign = math.copysign(1.0, n[2])
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    turn[0, 0], turn[1, 0], turn[2, 0] = 1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]
    turn[0, 1], turn[1, 1], turn[2, 1] = b, sign + n[1] * n[1] * a, -n[1]
    turn[0, 2], turn[1, 2], turn[2, 2] = n[0], n[1], n[2]


@numba.njit(cache=True, error_model="numpy")
def span(ends, half, turn, at):  # type: ignore[no-untyped-def]
    """Place a capsule between two points (6,): set half[2], the turn (3, 3) and the centre (3,)."""
    largest = 0.0
    for i in range(3):
        at[i] = 0.5 * ends[i] + 0.5 * ends[i + 3]
        largest = max(largest, abs(0.5 * ends[i + 3] - 0.5 * ends[i]))
    n = np.array([0.0, 0.0, 1.0])  # ends that coincide make a ball, which has no direction
    half[2] = 0.0
    if largest > 0.0:
        for i in range(3):
            n[i] = (0.5 * ends[i + 3] - 0.5 * ends[i]) / largest  # so that no square overflows
        length = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
        half[2] = largest * length
        for i in range(3):
            n[i] /= length
    complete(n, turn)


@numba.njit(cache=True, error_model="numpy")
def span_all(ends, rows, half, turns, places):  # type: ignore[no-untyped-def]
    """Place the capsules of several cables, which are the last shapes of the machine.

    Args:
        ends: Of all cables, shape (cables, 6).
        rows: Which of them have a shape, shape (shapes of cables,).
        half, turns, places: Written, as ``screen`` takes them.

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
