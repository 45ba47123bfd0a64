"""The least time for a way, where speed and its changes are limited, speed by speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array


@dataclass(frozen=True, eq=False)
class SpeedLimits:
    """How fast something is at most, and how fast that changes at each speed.

    Attributes:
        top: The largest speed; may be infinite.
        levels: Speeds, ascending from 0 to the largest, or to a smaller one, shape (k + 1,).
        gain: How fast the speed grows at most between neighbouring levels, shape (k,).
        loss: How fast it falls at most, shape (k,).
    """

    top: float
    levels: Array
    gain: Array
    loss: Array

    def least_time(self, length: float, start: float, end: float) -> float:
        """Return the least time in [s] for a way, its unit that of the speeds times [s].

        The speed w(t) is below that of the fastest start, since it passes each level no faster than
        ``gain`` lets it, and below that of the latest braking before the end. What lies below both
        is the longest way in a time; so no motion of that length is shorter.

        Args:
            length: Of the way, at least; a longer one takes no less.
            start: The largest speed at the beginning.
            end: The largest speed at the end.

        Source: Bobrow, Dubowsky, Gibson, Time-optimal control of robotic manipulators along
        specified paths, IJRR 4(3), 1985.
        """
        last = float(self.levels[-1])
        if not (length > 0.0 and last > 0.0):
            return 0.0
        start, end = min(max(start, 0.0), last), min(max(end, 0.0), last)
        levels = np.union1d(self.levels, [start, end])
        at = np.searchsorted(self.levels, 0.5 * (levels[1:] + levels[:-1])) - 1
        times, ways = np.zeros(len(levels)), np.zeros(len(levels))
        for rate, begin in ((self.gain[at], start), (self.loss[at], end)):
            low, high = np.maximum(levels[:-1], begin), np.maximum(levels[1:], begin)
            with np.errstate(divide="ignore", invalid="ignore"):  # a level that is never passed
                taken = np.where(high > low, (high - low) / np.maximum(rate, 0.0), 0.0)
            times[1:] += np.cumsum(taken)
            ways[1:] += np.cumsum(taken * 0.5 * (low + high))
        first = int(np.searchsorted(levels, start))
        if not ways[first] <= length:  # it cannot brake on so short a way
            return length / start
        j = int(np.flatnonzero(ways <= length)[-1])  # reaches that speed, and may keep it
        left, speed = length - float(ways[j]), float(levels[j])
        if j + 1 < len(levels) and np.isfinite(times[j + 1]):
            inverse = float((times[j + 1] - times[j]) / (levels[j + 1] - speed))
            peak = float(np.sqrt(speed**2 + 2.0 * left / inverse))
            return float(times[j]) + inverse * (peak - speed)
        return float(times[j]) + left / (self.top if j + 1 == len(levels) else speed)
