"""Peaks between samples: where a quantity is largest that was sampled along a motion."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.verification.between_samples.dense_motion import DenseMotion

# Each zoom leaves 2 of 16 parts about the largest sample. What a smooth peak of a hundredth of its
# unit is missed by shrinks by 64 each time: after 5, to less than rounding.
ZOOM_SAMPLES, ZOOMS = 17, 5

Excess = Callable[[Array, Array], Array]  # states (m, nx), held inputs (m, nu) -> (m, limits)


def peaks(
    dense: DenseMotion, times: Array, found: Array, excess: Excess, above: float
) -> tuple[Array, Array, Array]:
    """Find where quantities peak between samples, as far as that can lift them above a value.

    A parabola through three samples is higher than the largest of them by at most an eighth of
    what lies between it and the lowest of them, whether that is its neighbour or, where an input
    changes and a new parabola begins, the one after that. All of that is allowed for here.

    Args:
        dense: The motion.
        times: Of samples in [s], ascending, shape (m,).
        found: The quantities there, shape (m, n).
        above: Peaks that cannot be higher do not matter.

    Returns:
        Times (c,), states (c, nx) and held inputs (c, nu) of peaks.
    """
    rows, columns = _candidates(found, above)
    low, high = times[np.maximum(rows - 1, 0)], times[np.minimum(rows + 1, len(times) - 1)]
    at = times[rows]
    for _ in range(ZOOMS if rows.size else 0):
        grid = np.linspace(low, high, ZOOM_SAMPLES, axis=1)
        states, held = _moments(dense, grid.ravel())
        values = excess(states, held).reshape(*grid.shape, -1)
        best = values[np.arange(len(rows)), :, columns].argmax(axis=1)
        each = np.arange(len(rows))
        at = grid[each, best]
        low = grid[each, np.maximum(best - 1, 0)]
        high = grid[each, np.minimum(best + 1, ZOOM_SAMPLES - 1)]
    return at, *_moments(dense, at)


def _candidates(found: Array, above: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return rows and columns of samples about which there may be a peak above a value."""
    known = np.where(np.isfinite(found), found, -np.finfo(float).max)
    near = [known[np.clip(np.arange(len(known)) + k, 0, len(known) - 1)] for k in (-2, -1, 1, 2)]
    with np.errstate(over="ignore"):
        drop = known - np.min(near, axis=0)
        raised = (known >= near[1]) & (known >= near[2]) & (known + drop > above)
    rows, columns = np.nonzero(raised)
    return rows, columns


def _moments(dense: DenseMotion, times: Array) -> tuple[Array, Array]:
    """Return states and held inputs at times."""
    t = dense.motion.t
    knots = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 2)
    return dense.motion.along(knots, times), dense.trajectory.u[knots]
