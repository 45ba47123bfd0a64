"""Potential fields."""

from __future__ import annotations

from math import cos, hypot, sin

import numpy as np

from kinolab.testing.answers.judging import THREE_DIGITS, Exercise, require_number, require_values

CENTRE, RADIUS = (2.0, 1.0), 0.5  # [m] of the pillar
GAIN, REACH = 0.02, 0.6  # [m^3], [m] of its repulsion
PLACES = [(0.0, 0.0), (1.3, 0.8), (2.4, 1.5), (2.0, 1.7), (3.2, 1.0), (4.0, -2.0)]
POSES = [(0.0, 0.0, 1.0, 0.5, -0.3, 0.8), (0.4, 1.1, 0.0, 2.0, 1.0, -1.0), (2.0, -0.7, 3, 1, 0, 2)]
STEP = 1e-5  # [rad]
# [m], where the repulsion is 1: the real root of d^3 + gain / reach d = gain
(GAP,) = (float(d.real) for d in np.roots([1.0, 0.0, 0.01 / 0.5, -0.01]) if abs(d.imag) < 1e-9)


def _push(x: float, y: float) -> list[float]:
    """The force away from a round pillar, whose nearest point is on the line to its centre."""
    across, up = x - CENTRE[0], y - CENTRE[1]
    away = hypot(across, up)
    gap = away - RADIUS
    if gap >= REACH:
        return [0.0, 0.0]
    size = GAIN * (1.0 / gap - 1.0 / REACH) / gap**2
    return [size * across / away, size * up / away]


def _torques(q1: float, q2: float, *forces: float) -> list[float]:
    """The work of both forces when each joint turns a little."""

    def places(first: float, second: float) -> np.ndarray:
        elbow = [cos(first), sin(first)]
        return np.array([*elbow, elbow[0] + cos(first + second), elbow[1] + sin(first + second)])

    by_first = places(q1 + STEP, q2) - places(q1 - STEP, q2)
    by_second = places(q1, q2 + STEP) - places(q1, q2 - STEP)
    return [float(turned @ forces) / (2.0 * STEP) for turned in (by_first, by_second)]


EXERCISES = (
    Exercise("8.1", 2, lambda answer: require_values(answer, _push, PLACES)),
    Exercise("8.2", 3, lambda answer: require_values(answer, _torques, POSES)),
    Exercise("8.3", 2, lambda answer: require_number(answer, GAP, "m", THREE_DIGITS)),
)
