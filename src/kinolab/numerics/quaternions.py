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


def random_attitude(generator: np.random.Generator) -> Array:
    """Return an attitude from the uniform distribution on SO(3), shape (4,)."""
    return unit(generator.normal(size=4))


def random_attitudes(count: int, generator: np.random.Generator) -> Array:
    """Return attitudes as ``random_attitude`` does, shape (count, 4)."""
    return _directions(generator.normal(size=(count, 4)))


def turned_at_random(quaternion: Array, angle: float, generator: np.random.Generator) -> Array:
    """Return an attitude (4,) turned by at most an angle in [rad] about a random axis."""
    axis, half = unit(generator.normal(size=3)), generator.uniform(0, angle) / 2
    return multiply(quaternion, np.array([*(np.sin(half) * axis), np.cos(half)]))


def turned_by_at_most(quaternion: Array, angles: Array, generator: np.random.Generator) -> Array:
    """Return attitudes as ``turned_at_random`` does, one for each angle (n,), shape (n, 4)."""
    axes = _directions(generator.normal(size=(len(angles), 3)))
    halves = generator.uniform(0, angles)[:, None] / 2
    return multiply(quaternion, np.hstack([np.sin(halves) * axes, np.cos(halves)]))


def multiply(a: Array, b: Array) -> Array:
    """Return the attitude a (4,) turned by b (..., 4) in its own axes, of the same shape as b."""
    v, w, s, t = a[:3], b[..., :3], a[3], b[..., 3:]
    vector = s * w + t * v + np.cross(v, w)
    return np.concatenate([vector, s * t - (w @ v)[..., None]], axis=-1)


def _directions(vectors: Array) -> Array:
    directions: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return directions
