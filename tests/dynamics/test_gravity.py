"""Gravity along any direction: numbers of any kind, or expressions of parameters."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import sympy as sp

from kinolab.dynamics import Body, Gravity, System, length, move, parameter
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.errors import InputError

SLOPE = 0.3  # [rad]
S, C = sp.Float(SLOPE), parameter("slope", SLOPE, "rad")


@pytest.mark.parametrize(
    ("down", "strength"),
    [
        ((math.sin(SLOPE), 0, -math.cos(SLOPE)), 9.81),
        ((np.sin(SLOPE), np.float64(0.0), -np.cos(SLOPE)), np.float64(9.81)),
        ((sp.sin(S), 0, -sp.cos(S)), sp.Rational(981, 100)),
        ((sp.sin(C), 0, -sp.cos(C)), parameter("g", 9.81, "m/s^2")),
    ],
)
def test_gravity_takes_numbers_and_parameters(down: Any, strength: Any) -> None:
    x = length("x")
    sledge = System("sledge", bodies=[Body("b", move(x, 0, 0), mass=2.0)],
                    gravity=Gravity(down, strength))  # fmt: skip
    assert sledge.model().f([0.0, 0.0])[1] == pytest.approx(9.81 * math.sin(SLOPE), rel=1e-14)
    again = System.of(machine_from_json(machine_to_json(sledge)))
    assert again.model().f([0.0, 0.0])[1] == pytest.approx(9.81 * math.sin(SLOPE), rel=1e-14)


def test_a_slope_is_a_parameter_like_others() -> None:
    x, slope = length("x"), parameter("slope", SLOPE, "rad")
    down = (sp.sin(slope), 0, -sp.cos(slope))
    sledge = System("sledge", bodies=[Body("b", move(x, 0, 0), mass=2.0)],
                    gravity=Gravity(down, 9.81))  # fmt: skip
    assert sledge.model().f([0.0, 0.0], slope=0.1)[1] == pytest.approx(9.81 * math.sin(0.1))
    assert sledge.with_parameters(slope=0.0).down == (0.0, 0.0, -1.0)
    with pytest.raises(InputError, match=r"gravity: its direction is sin\(x\), 0\.0, -cos\(x\)\."):
        sledge.changed(gravity=Gravity((sp.sin(x), 0, -sp.cos(x)), 9.81))
    with pytest.raises(InputError, match=r"is not a unit vector\. Its length is 1\.0440"):
        sledge.changed(gravity=Gravity((0.3, 0, -1), 9.81))
