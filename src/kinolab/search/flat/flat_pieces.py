"""Pieces of a motion: polynomials in time of the flat outputs, up to degree five."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel

MOVE, TURN, BACK = 0, 1, 2  # along the outputs, on the spot, and along them with the rear ahead
TERMS = 6  # coefficients of a polynomial


class Pieces(NamedTuple):
    """Polynomials one after the other, for compiled kernels."""

    size: Annotated[Integers, 1]
    kind: Annotated[Integers, "pieces"]
    duration: Annotated[Array, "pieces"]  # in [s]
    heading: Annotated[Array, "pieces"]  # in [rad], where one rests
    c: Annotated[Array, "pieces", "axes", TERMS]  # powers of the time since its begin
    pose: Annotated[Array, "pieces", 3]  # of a car at its begin, whose axes are way and steering


@kernel
def jet(c, t):  # type: ignore[no-untyped-def]
    """Return a polynomial (TERMS,) and its first three derivatives at a time."""
    value, first, second, third = c[5], 0.0, 0.0, 0.0
    for k in range(4, -1, -1):
        third = third * t + second
        second = second * t + first
        first = first * t + value
        value = value * t + c[k]
    return value, first, 2.0 * second, 6.0 * third


@kernel
def fit_cubic(c, T, z0, v0, z1, v1):  # type: ignore[no-untyped-def]
    """Write the cubic between values and slopes at 0 and T.

    Args:
        c: Its coefficients, shape (TERMS,); written.
        T: The duration in [s].
        z0, v0, z1, v1: Value and slope at the beginning, and at the end.
    """
    c[0], c[1], c[4], c[5] = z0, v0, 0.0, 0.0
    c[2] = (3.0 * (z1 - z0) / T - 2.0 * v0 - v1) / T
    c[3] = (2.0 * (z0 - z1) / T + v0 + v1) / (T * T)


@kernel
def fit_quintic(c, T, z0, v0, a0, z1, v1, a1):  # type: ignore[no-untyped-def]
    """Write the quintic between values and two derivatives at 0 and T.

    Args:
        c: Its coefficients, shape (TERMS,); written.
        T: The duration in [s].
        z0, v0, a0, z1, v1, a1: Value and derivatives at the beginning, and at the end.
    """
    p = z1 - z0 - T * (v0 + 0.5 * T * a0)
    q = T * (v1 - v0 - T * a0)
    r = T * T * (a1 - a0)
    c[0], c[1], c[2] = z0, v0, 0.5 * a0
    c[3] = (10.0 * p - 4.0 * q + 0.5 * r) / T**3
    c[4] = (-15.0 * p + 7.0 * q - r) / T**4
    c[5] = (6.0 * p - 3.0 * q + 0.5 * r) / T**5


@kernel
def begin_later(c, t):  # type: ignore[no-untyped-def]
    """Shift a polynomial (TERMS,) in place so that its time counts from t."""
    for i in range(TERMS - 1):
        for j in range(TERMS - 2, i - 1, -1):
            c[j] += t * c[j + 1]


@kernel
def copy_piece(source, k, target, m):  # type: ignore[no-untyped-def]
    """Write the k-th of some pieces to the m-th of others."""
    target.kind[m], target.duration[m] = source.kind[k], source.duration[k]
    target.heading[m] = source.heading[k]
    for i in range(3):
        target.pose[m, i] = source.pose[k, i]
    for i in range(source.c.shape[1]):
        for j in range(TERMS):
            target.c[m, i, j] = source.c[k, i, j]


@kernel
def copy_pieces(source, target):  # type: ignore[no-untyped-def]
    """Write all pieces to others."""
    target.size[0] = source.size[0]
    for k in range(source.size[0]):
        copy_piece(source, k, target, k)


@kernel
def put_stretch(pieces, k, kind, z, direction, distance, speed, slope, T):  # type: ignore[no-untyped-def]
    """Write a piece along a straight line, with constant acceleration.

    Args:
        pieces, k: The pieces, and which of them.
        kind: MOVE, TURN or BACK.
        z: Where the line begins, shape (axes,).
        direction: Of the line, shape (axes,).
        distance, speed: Along it, at the beginning of the piece.
        slope: The acceleration along it.
        T: The duration in [s].
    """
    pieces.kind[k], pieces.duration[k] = kind, T
    pieces.heading[k] = z[2] if z.shape[0] == 3 else 0.0
    if z.shape[0] == 3 and kind != TURN and (direction[0] != 0.0 or direction[1] != 0.0):
        pieces.heading[k] = math.atan2(direction[1], direction[0])
    for i in range(z.shape[0]):
        c = pieces.c[k, i]
        c[0], c[1] = z[i] + distance * direction[i], speed * direction[i]
        c[2], c[3], c[4], c[5] = 0.5 * slope * direction[i], 0.0, 0.0, 0.0


@kernel
def total(pieces):  # type: ignore[no-untyped-def]
    """Return the duration of all pieces in [s]."""
    whole = 0.0
    for k in range(pieces.size[0]):
        whole += pieces.duration[k]
    return whole


@kernel
def locate_time(pieces, t):  # type: ignore[no-untyped-def]
    """Return the piece that a time since the first one is in, and the time since its begin."""
    last = pieces.size[0] - 1
    for k in range(last):
        if t < pieces.duration[k]:
            return k, t
        t -= pieces.duration[k]
    return last, min(t, pieces.duration[last])
