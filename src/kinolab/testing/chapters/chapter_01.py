"""Configuration spaces."""

from __future__ import annotations

from cmath import exp, phase
from math import cos, hypot, pi, sin

import numpy as np
from scipy.spatial.transform import Rotation

from kinolab.testing.answers.judging import Exercise, require_values

TORUS = [
    (0.3, -0.2, 1.0, 0.9),
    (3.0, 0.4, -3.0, 0.1),
    (-2.5, -3.1, 2.2, 3.0),
    (1.0, 8.0, 20.0, -15.0),
    (-40.0, 2.0, 1.5, 2.5),
]
SHADOWS = [
    (2.0, 0.5, 3.0),
    (2.0, 0.5, 1.8),
    (1.0, 0.4, 0.93),
    (2.0, 0.5, 1.2),
    (0.3, 0.5, 1.0),
    (1.0, 0.6, 0.7),
]


def _distance(a1: float, a2: float, b1: float, b2: float) -> float:
    """By the phases of points on the unit circle."""
    return hypot(phase(exp(1j * (b1 - a1))), 0.5 * phase(exp(1j * (b2 - a2))))


def _attitudes() -> list[tuple[np.ndarray, np.ndarray]]:
    """Pairs of attitudes, near and far, with either sign."""
    generator = np.random.default_rng(1)
    pairs = []
    for angle, sign in ((0.4, 1.0), (0.4, -1.0), (2.0, 1.0), (3.0, -1.0)):
        quaternion = generator.normal(size=4)
        axis = generator.normal(size=3)
        first = Rotation.from_quat(quaternion)
        second = first * Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
        given = second.as_quat()
        if np.dot(given, first.as_quat()) < 0:
            given = -given
        pairs.append((first.as_quat(), sign * given))
    return pairs


def _turned_by(p: np.ndarray, other: np.ndarray) -> float:
    """By the trace of a rotation matrix."""
    between = Rotation.from_quat(p).as_matrix().T @ Rotation.from_quat(other).as_matrix()
    return float(np.arccos((np.trace(between) - 1.0) / 2.0))


def _shadow(d: float, r: float, length: float) -> float:
    """Bisect for the largest angle at which the distance from link to centre is at most r."""

    def touches(theta: float) -> bool:
        along = min(max(d * cos(theta), 0.0), length)
        return hypot(d - along * cos(theta), along * sin(theta)) <= r

    if touches(pi) or not touches(0.0):
        return pi if touches(pi) else 0.0
    low, high = 0.0, pi
    for _ in range(60):
        middle = (low + high) / 2.0
        low, high = (middle, high) if touches(middle) else (low, middle)
    return low


EXERCISES = (
    Exercise("1.1", 2, lambda answer: require_values(answer, _distance, TORUS)),
    Exercise("1.2", 2, lambda a: require_values(a, _turned_by, _attitudes())),
    Exercise("1.3", 3, lambda answer: require_values(answer, _shadow, SHADOWS)),
)
