"""Matrices of intervals, many at once: their products, hulls and exponentials.

All are interval arrays (rows, columns, m), m of them side by side.
"""

from __future__ import annotations

import math

import numpy as np

from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.interval_analysis.interval_series import products, summed
from kinolab.numerics.intervals import IntervalArray

TERMS = 24  # of an exponential's series; the rest is bounded


def product(a: IntervalArray, b: IntervalArray) -> IntervalArray:
    """Return matrix products, (n, k, m) by (k, l, m)."""
    low, high = products(
        (_inner(a.low), _inner(a.high)), (np.swapaxes(b.low, 0, 0)[:, None], b.high[:, None])
    )
    found = summed(low, high)
    return IntervalArray(found.low, found.high)


def _inner(a: Array) -> Array:
    """Return a matrix with the axis that is summed over first, (k, n, 1, m)."""
    return np.swapaxes(a, 0, 1)[:, :, None]


def hull(a: IntervalArray, b: IntervalArray) -> IntervalArray:
    """Return the smallest intervals that contain two."""
    return IntervalArray(np.minimum(a.low, b.low), np.maximum(a.high, b.high))


def meet(a: IntervalArray, b: IntervalArray) -> IntervalArray:
    """Return what two enclosures of the same have in common."""
    return IntervalArray(np.fmax(a.low, b.low), np.fmin(a.high, b.high))


def within(a: IntervalArray, b: IntervalArray) -> Array:
    """Say where an interval lies in another one, shape (...)."""
    return np.asarray((b.low <= a.low) & (a.high <= b.high))


def middle(a: IntervalArray) -> Array:
    """Return a number in each, shape (...)."""
    return 0.5 * (a.low + a.high)


def radius(a: IntervalArray, at: Array) -> Array:
    """Return how far each reaches from a number in it, shape (...), rounding included."""
    reach = np.maximum(a.high - at, at - a.low)
    return reach * (1.0 + intervals.ROUNDING) + intervals.SMALLEST


def growth(rates: Array, inputs: Array) -> tuple[Array, Array]:
    """Bound exp(N) - 1 and phi(N) B for matrices N, B >= 0, with phi(z) = (exp(z) - 1) / z.

    The rest of a series after k terms is at most |N|^k / (k+1)! / (1 - |N| / (k+2)) in the norm of
    the largest row, after the entries are weighted so that this norm is small.

    Args:
        rates: N, shape (n, n, m).
        inputs: B, shape (n, k, m).

    Returns:
        Both, of the shapes of N and B; infinite where N is large.
    """
    matrices = np.moveaxis(rates, -1, 0)
    weights = _balance(matrices)
    norm = ((matrices @ weights) / weights).max(axis=(1, 2)) * (1.0 + 1e-12)
    # 0.5 (TERMS + 2): the rest is at most twice its first term
    sound = np.isfinite(norm) & (norm <= 0.5 * (TERMS + 2))
    usable, norm = np.where(sound[:, None, None], matrices, 0.0), np.where(sound, norm, 0.0)
    term = total = np.broadcast_to(np.eye(matrices.shape[1]), matrices.shape)
    for k in range(1, TERMS):
        term = term @ usable / (k + 1)
        total = total + term
    rest = 2.0 * norm**TERMS / math.factorial(TERMS + 1)
    # 1e-12: products of numbers >= 0 err by far less than that share
    phi = (total + rest[:, None, None] * weights / np.swapaxes(weights, 1, 2)) * (1.0 + 1e-12)
    phi = np.where(sound[:, None, None], phi, np.inf)
    grown, driven = phi @ matrices, phi @ np.moveaxis(inputs, -1, 0)
    return tuple(_sure(np.moveaxis(a, 0, -1)) for a in (grown, driven))  # type: ignore[return-value]


def _balance(matrices: Array) -> Array:
    """Return weights (m, n, 1) near the largest eigenvector of matrices >= 0, shape (m, n, n)."""
    weights = np.ones((*matrices.shape[:2], 1))
    usable = np.where(np.isfinite(matrices), matrices, 0.0)
    for _ in range(20):  # a power iteration; any weights give a bound
        weights = 1e-3 * weights + usable @ weights
        weights /= weights.max(axis=1, keepdims=True)
        weights = np.maximum(weights, 1e-9)
    return weights


def _sure(bounds: Array) -> Array:
    """Return bounds a little larger; infinite where they are not numbers."""
    return np.where(np.isnan(bounds), np.inf, bounds * (1.0 + 1e-12))
