"""The project: a machine of your own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, sin
from typing import Any

from kinolab.testing.answers.judging import (
    THREE_DIGITS,
    Exercise,
    WrongAnswerError,
    require_model,
    require_motion,
    require_number,
)

MASS, INERTIA, ARM, G = 0.8, 0.01, 0.2, 9.81  # [kg], [kg m^2], [m], [m/s^2]


def _drone(answer: Any) -> None:
    def accelerations(state: Mapping[str, float], thrust: Sequence[float]) -> dict[str, float]:
        left, right = thrust
        turn = state["theta"]  # about y: the nose, at +x, goes down
        return {
            "x": (left + right) * sin(turn) / MASS,
            "z": (left + right) * cos(turn) / MASS - G,
            "theta": ARM * (left - right) / INERTIA,
        }

    require_motion(answer, ["x", "z", "theta"], accelerations, inputs=2)
    model = require_model(answer)
    for name, (least, most) in zip(model.control_names, model.control_bounds, strict=True):
        if (least, most) != (0.0, 8.0):  # [N] of a rotor, least and most
            what = f"the limits of {name} are {least:g} and {most:g} N, not 0 and 8 N."
            raise WrongAnswerError(what)


EXERCISES = (
    Exercise("12.1", 2, lambda answer: require_number(answer, MASS * G / 2.0, "N", THREE_DIGITS)),
    Exercise("12.2", 4, _drone),
)
