"""Sampling-based planning: trees and roadmaps."""

from __future__ import annotations

from math import comb, pi

import numpy as np
from numpy.typing import NDArray

from kinolab.testing.answers.judging import Exercise, require_values

Array = NDArray[np.float64]

STATES = np.array([[3.1, 0.0], [0.1, 0.5], [-1.5, 2.0], [0.2, -4.0]])  # angles, rates
NEAREST_CASES = [
    (STATES, np.array([-3.1, 0.0]), 0.3),  # across the seam
    (STATES, np.array([0.1, -3.0]), 0.01),  # rates hardly count
    (STATES, np.array([0.1, -3.0]), 2.0),  # and count
    (STATES, np.array([-1.4, -4.0]), 0.3),
    (STATES, np.array([-3.0, 0.4]), 0.3),  # half a turn is far
    (STATES, np.array([-3.0, -3.5]), 0.7),  # and farther than the chord
    (STATES + np.array([2.0 * pi, 0.0]), np.array([-3.1, 0.2]), 0.3),  # angles may be wound up
]
FAILURE_CASES = [(100, 0.02, 1), (100, 0.02, 3), (500, 0.02, 3), (40, 0.3, 8), (3, 0.5, 5)]
HELD, PUSHES, WALL = 0.5, (-4.0, -1.0, 0.0, 1.0), 2.0  # [s], [m/s^2], [m]
EXTEND_CASES = [
    ((0.0, 0.0), (1.0, 1.0)),
    ((0.0, 1.0), (0.1, 0.0)),
    ((1.9, -0.2), (2.5, 0.0)),  # of the ends before the wall the nearest
    ((1.4, 1.0), (2.0, 2.0)),  # pushing on would hit the wall
    ((1.985, 0.2), (2.0, 0.0)),  # a gentle brake would hit it, and end before it
    ((1.5, 1.2), (2.0, 0.7)),  # braking gently it would turn behind the wall, but not yet
    ((1.9, -0.6), (1.5, -1.1)),  # it would have turned behind the wall, before the start
    ((1.0, 0.3), (1.2, 0.3)),
]


def _nearest(states: Array, sample: Array, weight: float) -> int:
    """Compare chords' angles: the argument of a complex number knows no seam."""
    turned = np.exp(1j * states[:, 0]) / np.exp(1j * sample[0])
    squares = np.angle(turned) ** 2 + (weight * (states[:, 1] - sample[1])) ** 2
    return int(squares.argmin())


def _failure(n: int, p: float, k: int) -> float:
    """Return the probability of fewer than k successes among n."""
    return sum(comb(n, i) * p**i * (1.0 - p) ** (n - i) for i in range(min(k, n + 1)))


def _extended(state: tuple[float, float], target: tuple[float, float]) -> list[float]:
    (x, v), (x_wanted, v_wanted) = state, target
    times = np.linspace(0.0, HELD, 2001)
    free: list[tuple[float, float]] = []
    for push in PUSHES:
        way = x + v * times + push * times**2 / 2
        if way.max() < WALL:
            free.append((float(way[-1]), v + push * HELD))
    misses = [(x_end - x_wanted) ** 2 + (v_end - v_wanted) ** 2 for x_end, v_end in free]
    return list(free[misses.index(min(misses))])


EXERCISES = (
    Exercise("7.1", 2, lambda a: require_values(a, _nearest, NEAREST_CASES)),
    Exercise("7.2", 2, lambda answer: require_values(answer, _failure, FAILURE_CASES)),
    Exercise("7.3", 2, lambda answer: require_values(answer, _extended, EXTEND_CASES)),
)
