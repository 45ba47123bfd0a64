"""Cubic Hermite curves, and poses as such curves."""

from __future__ import annotations

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.scene.content import Curve


def hermite(
    begin: Array, out: Array, end: Array, into: Array, step: Array, fraction: Array
) -> Array:
    """Return a cubic at a fraction of each step, from values and rates of change at both ends.

    Shapes broadcast: values and rates (..., d), steps and fractions.

    Source: de Boor, A Practical Guide to Splines, rev. ed., 2001, chapter IV.
    """
    s = fraction
    return np.asarray(
        (1.0 + 2.0 * s) * (1.0 - s) ** 2 * begin
        + s * (1.0 - s) ** 2 * step * out
        + s * s * (3.0 - 2.0 * s) * end
        - s * s * (1.0 - s) * step * into
    )


def evaluated(curve: Curve, at: Array) -> Array:
    """Return the values of a curve at times (n,), shape (n, d), clamped to its ends."""
    if len(curve.times) == 1:
        return np.repeat(curve.values, len(at), axis=0)
    row = np.clip(np.searchsorted(curve.times, at, side="right") - 1, 0, len(curve.times) - 2)
    step = (curve.times[row + 1] - curve.times[row])[:, None]
    fraction = np.clip((at - curve.times[row])[:, None] / step, 0.0, 1.0)
    values, out, into = curve.values, curve.leaving, curve.arriving
    return hermite(values[row], out[row], values[row + 1], into[row + 1], step, fraction)


def turn_rates(quaternion: Array, poses: Array, rates: Array) -> Array:
    """Return the rates of quaternions (..., 4), from the rates of poses (..., 12).

    With R' = R hat(w), w in body axes, q' = q (w, 0) / 2.
    """
    R = poses.reshape(*poses.shape[:-1], 3, 4)[..., :3]
    S = np.swapaxes(R, -1, -2) @ rates.reshape(*rates.shape[:-1], 3, 4)[..., :3]
    S = 0.5 * (S - np.swapaxes(S, -1, -2))
    w = np.stack([S[..., 2, 1], S[..., 0, 2], S[..., 1, 0]], axis=-1)
    v, s = quaternion[..., :3], quaternion[..., 3:]
    scalar = -np.sum(v * w, axis=-1, keepdims=True)
    return np.asarray(0.5 * np.concatenate([s * w + np.cross(v, w), scalar], axis=-1))


def continued(curve: Curve) -> Curve:
    """Return a curve of quaternions with signs chosen for continuity."""
    q = curve.values
    away = np.sum(q[1:] * q[:-1], axis=-1, keepdims=True) < 0.0
    sign = np.concatenate([[[1.0]], np.where(np.cumsum(away, axis=0) % 2, -1.0, 1.0)])
    return Curve(curve.times, sign * q, sign * curve.arriving, sign * curve.leaving)
