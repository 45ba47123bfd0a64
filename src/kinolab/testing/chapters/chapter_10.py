"""Feedback, and machines that fall over."""

from __future__ import annotations

from math import acosh, sqrt
from typing import Any

import numpy as np

from kinolab.testing.answers.judging import THREE_DIGITS, Exercise, require_number, require_values

G = 9.81  # [m/s^2]
ROD = 0.5  # [m]
RELEASED, FALLEN = 0.001, 10.0  # [deg] off the upright
TIME = acosh(FALLEN / RELEASED) / sqrt(G / ROD)  # [s]: it grows as cosh(sqrt(g / l) t)
DEVIATIONS = 4  # of six states of cart and two equal poles: their difference and its rate are free


def _riccati(answer: Any) -> None:
    """P of the algebraic Riccati equation, for stable and unstable machines, one and two inputs."""
    from scipy.linalg import solve_continuous_are

    generator = np.random.default_rng(10)
    cases = [
        (np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]]), np.eye(2), np.eye(1)),
        (np.array([[0.0, 1.0], [9.81, 0.0]]), np.array([[0.0], [2.0]]), np.eye(2), 0.1 * np.eye(1)),
    ]
    for states, inputs in ((3, 1), (4, 2)):
        A = generator.normal(size=(states, states))
        B = generator.normal(size=(states, inputs))
        Q = np.diag(generator.uniform(0.5, 2.0, states))
        R = np.diag(generator.uniform(0.5, 2.0, inputs))
        cases.append((A, B, Q, R))
    require_values(answer, solve_continuous_are, cases)


EXERCISES = (
    Exercise("10.1", 1, lambda answer: require_number(answer, TIME, "s", THREE_DIGITS)),
    Exercise("10.2", 3, _riccati),
    Exercise("10.3", 2, lambda answer: require_number(answer, DEVIATIONS)),
)
