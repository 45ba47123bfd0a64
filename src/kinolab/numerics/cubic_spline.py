"""Cubic splines through samples.

SciPy's would take a quarter of a second to import, longer than most searches.

Source: de Boor, A Practical Guide to Splines, revised ed., 2001, chapter IV.
"""

from __future__ import annotations

import numpy as np

from kinolab.numerics.arrays import Array


class CubicSpline:
    """Piecewise cubic polynomials, twice differentiable, without a knot next to either end.

    Args:
        x: Where the samples are, increasing, shape (n,), n >= 4.
        y: The samples, shape (n, k).
    """

    def __init__(self, x: Array, y: Array) -> None:
        h = np.diff(x)
        chord = np.diff(y, axis=0) / h[:, None]
        slopes = _slopes(h, chord)
        bend = (slopes[:-1] + slopes[1:] - 2 * chord) / h[:, None]
        self._x = x
        self._powers = (y[:-1], slopes[:-1], (chord - slopes[:-1]) / h[:, None] - bend,
                        bend / h[:, None])  # fmt: skip

    def __call__(self, x: Array) -> Array:
        """Return the values at places (m,), shape (m, k); the last cubics go on beyond the ends."""
        piece = np.clip(np.searchsorted(self._x, x, side="right") - 1, 0, len(self._x) - 2)
        t = (x - self._x[piece])[:, None]
        constant, linear, square, cube = (power[piece] for power in self._powers)
        return np.asarray(constant + t * (linear + t * (square + t * cube)))


def _slopes(h: Array, chord: Array) -> Array:
    """Return the slopes at all samples, shape (n, k), from distances (n-1,) and chords (n-1, k)."""
    n = len(h) + 1
    inner = np.arange(1, n - 1)
    A, b = np.zeros((n, n)), np.empty((n, chord.shape[1]))
    A[inner, inner - 1], A[inner, inner + 1] = h[1:], h[:-1]
    A[inner, inner] = 2 * (h[1:] + h[:-1])
    b[1:-1] = 3 * (h[1:, None] * chord[:-1] + h[:-1, None] * chord[1:])
    A[0, :2], b[0] = _end(h[0], h[1], chord[0], chord[1])
    A[-1, :-3:-1], b[-1] = _end(h[-1], h[-2], chord[-1], chord[-2])
    return np.asarray(np.linalg.solve(A, b))


def _end(h: float, next_h: float, chord: Array, next_chord: Array) -> tuple[Array, Array]:
    """Return the equation that makes the first two pieces one polynomial: row (2,), right (k,)."""
    both = h + next_h
    right = ((h + 2 * both) * next_h * chord + h**2 * next_chord) / both
    return np.array([next_h, both]), right
