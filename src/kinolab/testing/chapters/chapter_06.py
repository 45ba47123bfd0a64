"""Flatness and steering."""

from __future__ import annotations

from math import atan2, cos, hypot, sin, sqrt, tan

import numpy as np

from kinolab.testing.answers.judging import THREE_DIGITS, Exercise, require_number, require_values

G, HEIGHT = 9.81, 9.0  # [m/s^2], [m] of the trolley
LENGTH, RADIUS, MASS = 3.0, 0.25, 1.0  # [m], [m], [kg]
ROLL, TORQUE = 12.0, 1.0  # [rad/s], [N m]
VELOCITIES = [(1.0, 0.0, 0.3, 0.7), (0.4, -1.1, -0.6, 0.2), (-2.0, 0.5, 1.0, 1.5)]
# [s] by the rate of the timing, which is 15/8 at most, and by its slope, 10/sqrt(3)
SHORTEST = max(
    LENGTH * 15.0 / 8.0 / (ROLL * RADIUS),
    sqrt(1.5 * MASS * RADIUS * LENGTH * 10.0 / sqrt(3.0) / TORQUE),
)
LOADS = [(4.0, 2.0, 0.0, 0.0), (1.5, 3.0, 1.8, 0.4), (-2.0, 5.0, -2.5, -1.2)]


def _reversing(x1: float, y1: float, x2: float, y2: float) -> list[float]:
    """The heading is opposite to the velocity, and turns as that does."""
    psi = atan2(-y1, -x1)
    along = np.array([cos(psi), sin(psi)])
    v = float(along @ [x1, y1])
    aside = np.array([-along[1], along[0]])
    return [along[0], along[1], v, float(aside @ [x2, y2]) / v]


def _crane(X: float, Z: float, X2: float, Z2: float) -> list[float]:
    """The pull points from the load to the trolley, and is the acceleration less gravity."""
    pull = np.array([X2, Z2 + G]) / hypot(X2, Z2 + G)
    rope = (HEIGHT - Z) / pull[1]
    theta = atan2(-pull[0], pull[1])
    return [theta, rope, X - (HEIGHT - Z) * tan(theta)]


EXERCISES = (
    Exercise("6.1", 2, lambda answer: require_values(answer, _reversing, VELOCITIES)),
    Exercise("6.2", 3, lambda answer: require_values(answer, _crane, LOADS)),
    Exercise("6.3", 2, lambda answer: require_number(answer, SHORTEST, "s", THREE_DIGITS)),
)
