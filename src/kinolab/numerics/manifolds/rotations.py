"""Unit quaternions (x, y, z, w) as stored in states; q and -q are the same attitude."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from kinolab.numerics.arrays import Array


def unit(vector: ArrayLike) -> Array:
    """Return a quaternion or another vector scaled to unit length, of the same shape."""
    q = np.asarray(vector, dtype=float)
    scaled = q / np.abs(q).max()  # avoids overflow of the norm
    turned: Array = scaled / np.linalg.norm(scaled)
    return turned


def turn_between(a: ArrayLike, b: ArrayLike) -> Array:
    """Return the angles in [rad], 0 to pi, between attitudes (..., 4) and others, shape (...)."""
    p, q = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    apart, together = np.linalg.norm(p - q, axis=-1), np.linalg.norm(p + q, axis=-1)
    turns: Array = 4 * np.arctan2(np.minimum(apart, together), np.maximum(apart, together))
    return turns


def of_matrices(matrices: Array) -> Array:
    """Return unit quaternions (..., 4) of rotation matrices (..., 3, 3).

    The largest of the four components is the one that is found by a square root.

    Source: Shepperd, Quaternion from Rotation Matrix, J. Guidance and Control 1(3), 1978.
    """
    R = np.asarray(matrices, dtype=np.float64)
    trace = np.trace(R, axis1=-2, axis2=-1)[..., None]
    diagonal = np.diagonal(R, axis1=-2, axis2=-1)
    twice = np.concatenate([1.0 + 2.0 * diagonal - trace, 1.0 + trace], axis=-1)
    upper, lower = (
        np.stack([R[..., i, j] for i, j in pairs], axis=0)
        for pairs in (((2, 1), (0, 2), (1, 0)), ((1, 2), (2, 0), (0, 1)))
    )
    (a, b, c), (d, e, f) = upper + lower, upper - lower
    x, y, z, w = np.moveaxis(twice, -1, 0)  # four times the squares
    rows = np.stack([
        np.stack([x, c, b, d], axis=-1),
        np.stack([c, y, a, e], axis=-1),
        np.stack([b, a, z, f], axis=-1),
        np.stack([d, e, f, w], axis=-1),
    ], axis=-2)  # fmt: skip
    largest = np.argmax(twice, axis=-1)[..., None, None]
    q = np.take_along_axis(rows, largest, axis=-2)[..., 0, :]
    return unit_rows(q)


def of_poses(poses: Array) -> Array:
    """Return unit quaternions x, y, z, w of poses [R | p], shape (..., 12) to (..., 4)."""
    return of_matrices(poses.reshape(*poses.shape[:-1], 3, 4)[..., :3])


def to_matrices(quaternions: Array) -> Array:
    """Return rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    x, y, z, w = np.moveaxis(np.asarray(quaternions, dtype=np.float64), -1, 0)
    entries = [
        1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
        2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
        2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y),
    ]  # fmt: skip
    return np.stack(entries, axis=-1).reshape(*x.shape, 3, 3)


def slerp(start: Array, end: Array, fraction: Array) -> Array:
    """Return attitudes on the shorter arcs between others (..., 4), at fractions (...) of them.

    Source: Shoemake, Animating Rotation with Quaternion Curves, SIGGRAPH 1985.
    """
    together = np.sum(start * end, axis=-1, keepdims=True) >= 0.0
    near = np.where(together, end, -end)
    half = turn_between(start, near)[..., None] / 2  # at most a right angle
    part, sine = np.asarray(fraction)[..., None], np.sin(half)
    small = sine < 1e-8  # [rad]; below it an arc is a straight line to 1e-16
    divided = np.where(small, 1.0, sine)
    a = np.where(small, 1.0 - part, np.sin((1.0 - part) * half) / divided)
    b = np.where(small, part, np.sin(part * half) / divided)
    return unit_rows(a * start + b * near)


def multiply(a: Array, b: Array) -> Array:
    """Return the attitude a (4,) turned by b (..., 4) in its own axes, of the same shape as b."""
    v, w, s, t = a[:3], b[..., :3], a[3], b[..., 3:]
    vector = s * w + t * v + np.cross(v, w)
    return np.concatenate([vector, s * t - (w @ v)[..., None]], axis=-1)


def unit_rows(vectors: Array) -> Array:
    """Return vectors scaled to unit length, each row (..., n) by itself."""
    directions: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return directions
