"""Mechanics that switch."""

from __future__ import annotations

from math import pi, sin, sqrt
from typing import Any

import numpy as np

from kinolab.errors import KinolabError
from kinolab.testing.answers.judging import (
    Exercise,
    WrongAnswerError,
    require_model,
    require_values,
)

G = 9.81  # [m/s^2]
CEILING = 2.0  # [m] above the floor
FLOOR_KEEPS, CEILING_KEEPS = 0.9, 0.5  # of the speed of a ball
THROWS = [(1.0, 0.0, 0.8), (1.0, 6.0, 0.3), (0.5, -3.0, 0.9), (1.5, 8.0, 1.2)]  # [m], [m/s], [s]
STEP = 0.01  # [s]


def _way(h0: float, e: float) -> float:
    """The drop, and twice the height of each bounce; a geometric series."""
    return h0 + 2.0 * h0 * e**2 / (1.0 - e**2)


def _thrown(h: float, v: float, t: float) -> list[float]:
    """Height and speed of a ball between floor and ceiling, t seconds later."""
    while True:
        at_floor = (v + sqrt(v**2 + 2.0 * G * h)) / G
        square = v**2 - 2.0 * G * (CEILING - h)
        at_ceiling = (v - sqrt(square)) / G if v > 0.0 and square > 0.0 else np.inf
        event = min(at_floor, at_ceiling)
        if t < event:
            return [h + v * t - G * t**2 / 2.0, v - G * t]
        speed = v - G * event
        above = at_ceiling < at_floor
        h, v = (CEILING, -CEILING_KEEPS * speed) if above else (0.0, -FLOOR_KEEPS * speed)
        t -= event


def _between(answer: Any) -> None:
    model = require_model(answer)
    if model.state_names != ("h", "h_dot", "mode"):
        names = ", ".join(model.state_names)
        raise WrongAnswerError(f"its states are {names}, not h, h_dot, mode.")
    if model.nu:
        raise WrongAnswerError(f"it has {model.nu} inputs, and none is wanted.")
    for h, v, t in THROWS:
        thrown = f"thrown at {h:g} m with {v:g} m/s"
        try:
            state = np.array([h, v, 0.0])
            for _ in range(round(t / STEP)):  # no impact may be over within one step
                state = model.step(state, [], STEP)
        except KinolabError as error:
            raise WrongAnswerError(f"{thrown}, it fails: {error}") from error
        due = np.array(_thrown(h, v, t))
        if not (np.abs(state[:2] - due) <= 1e-6).all():  # [m], [m/s]
            own, right = (f"at {one[0]:.4g} m with {one[1]:.4g} m/s" for one in (state, due))
            raise WrongAnswerError(f"{thrown}, after {t:g} s it is {own}", right)


EXERCISES = (
    Exercise(
        "11.1",
        2,
        lambda answer: require_values(answer, _way, [(1.0, 0.0), (1.0, 0.5), (2.0, 0.9)]),
    ),
    Exercise("11.2", 3, _between),
    Exercise(
        "11.3",
        2,
        lambda answer: require_values(
            answer, lambda n: sin(2.0 * pi / n) ** 2, [(5,), (8,), (12,)]
        ),
    ),
)
