"""The square of the angle between attitudes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sympy import lambdify

from kinolab.dynamics import rotation, squared_turn

ROUNDING = 1e-13  # of 256 times a number next to 1


@pytest.mark.parametrize("size", [0.0, 1e-6, 1e-3, 0.1, 1.0, 3.0, math.pi - 1e-9, 1.5 * math.pi])
def test_it_is_that_of_the_shorter_turn(size: float) -> None:
    """As SciPy has it; q and -q are one attitude."""
    generator, attitude = np.random.default_rng(3), rotation("R")
    for _ in range(5):
        rest = Rotation.from_quat(generator.normal(size=4))
        axis = generator.normal(size=3)
        turned = rest * Rotation.from_rotvec(size * axis / np.linalg.norm(axis))
        square = lambdify(attitude.quaternion, squared_turn(attitude, tuple(rest.as_quat())))
        wanted = (rest.inv() * turned).magnitude() ** 2
        for sign in (1.0, -1.0):
            assert abs(square(*sign * turned.as_quat()) - wanted) <= ROUNDING
