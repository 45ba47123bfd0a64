"""The feedback along a plan on sets of states: gains, errors of measurement, limits of inputs.

Inputs are cut at their limits. What a cut makes of all inputs between two ends lies between two
parallel lines: of that strip the slope goes into the gains, and the width is an input of its own.

Source: Singh, Gehr, Mirman, Pueschel, Vechev, Fast and effective robustness certification, NeurIPS
2018, theorem 3.1 (the strip of least area around a cut line).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.interval_analysis.zonotopes import SUMS, Zonotope


@dataclass(frozen=True, eq=False)
class HeldInputs:
    """The deviations of inputs from the planned ones over a set of states.

    v = centre - gain y + steps b, where y is the deviation of the state and b is in [-1, 1].

    Attributes:
        gain: What of the gains is left where inputs are cut, shape (nu, nx).
        centre: Shape (nu,).
        steps: Generators that are new in every step, shape (nu, count).
        low: Lower bound of v, with disturbances, shape (nu,).
        high: Upper bound.
        cut: Whether an input may be cut, shape (nu,).
    """

    gain: Array
    centre: Array
    steps: Array
    low: Array
    high: Array
    cut: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class HeldFeedback:
    """Inputs that a tracker gives at the beginning of a step, and that are held to its end.

    Attributes:
        gain: On deviations from the plan, shape (nu, nx).
        planned: The planned inputs, shape (nu,).
        offset: The nominal state less that of the plan, shape (nx,).
        limits: Of the inputs, shape (nu, 2).
        noise: By how much measurements are off at most, shape (nx,).
        disturbance: By how much inputs are off at most, after they are cut, shape (nu,).
    """

    gain: Array
    planned: Array
    offset: Array
    limits: Array
    noise: Array
    disturbance: Array

    def over(self, y: Zonotope) -> HeldInputs:
        """Return the inputs over a set of deviations of the state."""
        wanted = y.plus(self.offset).mapped(-self.gain)
        shaken = np.abs(self.gain) @ self.noise
        low, high = (
            wanted.bounds.low - shaken * (1.0 + SUMS),
            wanted.bounds.high + shaken * (1.0 + SUMS),
        )
        share, middle, half = _strip(low, high, *(self.limits - self.planned[:, None]).T)
        gain = share[:, None] * self.gain
        off = SUMS * (np.abs(self.gain) @ (y.magnitude + np.abs(self.offset) + self.noise))
        off = off + 1e-15 * np.abs(self.limits).max(axis=1)  # of limits less planned inputs
        steps = [gain * self.noise, np.diag(half + off), np.diag(self.disturbance)]
        ends = np.clip([low, high], *(self.limits - self.planned[:, None]).T)
        cut = share < 1.0
        slack = self.disturbance + 4 * off
        centre = middle - gain @ self.offset
        return HeldInputs(gain, centre, np.hstack(steps), ends[0] - slack, ends[1] + slack, cut)


def _strip(low: Array, high: Array, least: Array, most: Array) -> tuple[Array, Array, Array]:
    """Return slope, middle and half width of strips that contain what cuts make of [low, high].

    Args:
        low: Lower ends, shape (nu,).
        high: Upper ends.
        least: Lower limits, shape (nu,).
        most: Upper limits.
    """
    ends, wide = np.clip([low, high], least, most), high - low
    slope = np.divide(ends[1] - ends[0], wide, out=np.ones_like(wide), where=wide > 0)
    inside = (low >= least) & (high <= most)
    slope = np.where(inside, 1.0, np.clip(slope, 0.0, 1.0))
    places = np.clip([low, high, least, most], low, high)  # where the difference can be extreme
    apart = np.clip(places, least, most) - slope * places
    middle = np.where(inside, 0.0, 0.5 * (apart.min(axis=0) + apart.max(axis=0)))
    half = np.where(inside, 0.0, np.abs(apart - middle).max(axis=0))
    # a few roundings of what was subtracted
    slack = np.where(inside, 0.0, 1e-15 * np.abs(places).max(axis=0))
    return slope, middle, half + slack
