"""Lagrangian mechanics: from the pendulum to the rolling disk."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import cos, sin
from typing import Any

from kinolab.testing.answers.judging import (
    Exercise,
    WrongAnswerError,
    require_motion,
    require_number,
    require_values,
)

G = 9.81  # [m/s^2]
REST, STIFFNESS = 1.0, 50.0  # [m], [N/m] of the spring
CASES = [(0.0, 0.0, 0.0, 0.0), (0.3, -0.8, 1.2, 0.4), (1.5, 2.5, -0.7, 2.0), (-2.0, 0.1, 3.0, -1.0)]


def _two_pendulums(answer: Any) -> None:
    """T and V, this one less its value at rest, where both hang."""

    def kinetic(q1: float, q2: float, r1: float, r2: float) -> float:
        return r1**2 + 0.5 * r2**2 + r1 * r2 * cos(q1 - q2)

    def potential(q1: float, q2: float, _r1: float, _r2: float) -> float:
        return G * (3.0 - 2.0 * cos(q1) - cos(q2))

    def own(*case: float) -> Any:
        return answer(*case)[1] - answer(0.0, 0.0, 0.0, 0.0)[1]

    if not callable(answer):
        raise WrongAnswerError(f"a function is wanted, not {answer!r}.")
    _named("T", lambda *case: answer(*case)[0], kinetic)
    _named("V less its value where both hang", own, potential)


def _named(name: str, given: Callable[..., Any], right: Callable[..., float]) -> None:
    try:
        require_values(given, right, CASES)
    except WrongAnswerError as error:
        raise WrongAnswerError(f"{name}: {error.told}", error.due) from error


def _elastic_pendulum(answer: Any) -> None:
    def accelerations(state: Mapping[str, float], _: Sequence[float]) -> dict[str, float]:
        r, theta, r_dot, turn = (state[n] for n in ("r", "theta", "r_dot", "theta_dot"))
        return {
            "r": r * turn**2 + G * cos(theta) - STIFFNESS * (r - REST),
            "theta": -(2.0 * r_dot * turn + G * sin(theta)) / r,
        }

    require_motion(answer, ["r", "theta"], accelerations)


EXERCISES = (
    Exercise("3.1", 2, _two_pendulums),
    Exercise("3.2", 3, _elastic_pendulum),
    Exercise("3.3", 1, lambda answer: require_number(answer, 2.0)),
)
