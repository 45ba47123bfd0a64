"""Vector fields, brackets and controllability."""

from __future__ import annotations

from math import cos, sin, tan
from typing import Any

import numpy as np

from kinolab.testing.answers.judging import Exercise, WrongAnswerError, require_values

RADIUS, TRACK = 0.1, 0.4  # [m] of the wheels, [m] between them
WHEELBASE = 2.7  # [m]
GROWTH = ((2, 3, 4, 5), (2, 3, 4, 4, 5))  # Jean 1996: ordinary, and with a right angle
STEPS = 2000  # of the integration along each arc


def _wheels(psi: float) -> list[float]:
    turned = RADIUS**2 / TRACK
    return [turned * sin(psi), -turned * cos(psi), 0.0]


def _train(answer: Any) -> None:
    try:
        given = tuple(tuple(int(entry) for entry in growth) for growth in answer)
    except (TypeError, ValueError) as error:
        raise WrongAnswerError(f"two tuples of numbers are wanted, not {answer!r}.") from error
    if len(given) != len(GROWTH):
        raise WrongAnswerError(f"two growth vectors are wanted, not {len(given)}.")
    for place, ours, theirs in zip(("ordinary", "singular"), GROWTH, given, strict=True):
        if ours != theirs:
            raise WrongAnswerError(f"at the {place} configuration it is {theirs}", f"{ours}")


def _aside(length: float, steering: float) -> float:
    """Integrate both arcs by the midpoint rule, from headings that are known."""
    middle = (np.arange(STEPS) + 0.5) * length / STEPS
    bend = tan(steering) / WHEELBASE
    headings = np.concatenate([-bend * middle, -bend * (length - middle)])
    return float(-np.sin(headings).sum() * length / STEPS)


EXERCISES = (
    Exercise("5.1", 2, lambda a: require_values(a, _wheels, [(0.0,), (0.7,), (2.0,), (-1.3,)])),
    Exercise("5.2", 3, _train),
    Exercise("5.3", 2, lambda a: require_values(a, _aside, [(0.2, 0.3), (1.5, 0.5), (4.0, -0.4)])),
)
