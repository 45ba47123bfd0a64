"""Constraints and multipliers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, radians, sin
from typing import Any

import numpy as np

from kinolab.testing.answers.judging import (
    THREE_DIGITS,
    Exercise,
    WrongAnswerError,
    require_motion,
    require_number,
    require_values,
)

G, FRICTION, SPEED = 9.81, 0.6, 1.5  # [m/s^2], of the rim, [m/s]
RADIUS, SLOPE = 0.25, radians(10.0)  # [m], [rad]

Case = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def _cases() -> list[Case]:
    """Mass matrices, forces, constraints and what these have of second order."""
    generator = np.random.default_rng(4)
    cases = []
    for n, k in ((2, 1), (4, 2), (5, 3), (6, 1)):
        root = generator.normal(size=(n, n))
        mass = root @ root.T + np.eye(n)
        rest = (generator.normal(size=n), generator.normal(size=(k, n)), generator.normal(size=k))
        cases.append((mass, *rest))
    return cases


def _both(mass: np.ndarray, force: np.ndarray, rows: np.ndarray, bend: np.ndarray) -> np.ndarray:
    """Accelerations and multipliers, of all equations at once."""
    k = len(rows)
    matrix = np.block([[mass, -rows.T], [rows, np.zeros((k, k))]])
    return np.linalg.solve(matrix, np.concatenate([force, -bend]))


def _multipliers(answer: Any) -> None:
    def joined(*case: np.ndarray) -> Any:
        returned = answer(*case)
        if isinstance(returned, tuple | list) and any(np.ndim(entry) > 0 for entry in returned):
            raise WrongAnswerError(f"it returns {len(returned)} arrays, and one array is wanted.")
        return returned

    require_values(joined if callable(answer) else answer, _both, _cases())


def _slope(answer: Any) -> None:
    def accelerations(state: Mapping[str, float], _: Sequence[float]) -> dict[str, float]:
        return {"psi": 0.0, "phi": 2.0 * G * sin(SLOPE) * cos(state["psi"]) / (3.0 * RADIUS)}

    require_motion(answer, ["psi", "phi"], accelerations)


EXERCISES = (
    Exercise(
        "4.1", 1, lambda answer: require_number(answer, FRICTION * G / SPEED, "rad/s", THREE_DIGITS)
    ),
    Exercise("4.2", 3, _multipliers),
    Exercise("4.3", 3, _slope),
)
