"""Wheels that lean: what is drawn stays on the ground, and nowhere below it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from kinolab import systems
from kinolab.dynamics import Disk, Model

Array = NDArray[np.float64]

MACHINES = ("falling_disk", "unicycle", "motorcycle", "whipple")


def lowest(model: Model, x: Array) -> Array:
    """Height in [m] of the lowest point of every disk that touches the ground.

    A disk about n reaches down by r sqrt(1 - n_z^2) along its rim and by half its thickness times
    |n_z| along its axle.
    """
    found = []
    frames = model.frames(x).reshape(-1, 3, 4)
    for body, frame in zip(model.system.bodies, frames, strict=True):
        if not body.touches_ground:
            continue
        tilt = frame[2, 1]
        for shape in model.system.resolved_shapes(body):
            assert isinstance(shape, Disk)
            assert shape.axis == "y"
            reach = shape.radius * np.sqrt(1 - tilt**2) + shape.thickness / 2 * abs(tilt)
            found.append(frame[2, 3] - reach)
    return np.array(found)


def states(model: Model) -> list[Array]:
    """Random postures within the limits, a bicycle's front wheel on the ground."""
    rng, made = np.random.default_rng(0), []
    lower, upper = np.clip(model.state_bounds, -1.5, 1.5).T
    for x in rng.uniform(lower, upper, (100, model.nx)):
        if model.system.name == "whipple":
            pitch = model.state_names.index("theta")
            x[pitch] = pitched(model, x, pitch)
        made.append(x)
    return made


def pitched(model: Model, x: Array, pitch: int) -> float:
    """Pitch at which the front wheel touches the ground."""

    def gap(theta: float) -> float:
        y = x.copy()
        y[pitch] = theta
        return float(model.constraint_residual(y)[-1])

    return float(brentq(gap, -0.4, 0.4, xtol=1e-14))


@pytest.mark.parametrize("name", MACHINES)
def test_no_wheel_sinks_however_far_it_leans(name: str) -> None:
    model = systems.get(name).model()
    heights = np.array([lowest(model, x) for x in states(model)])
    assert heights.min() > -1e-12  # [m]
    assert heights.max() < 0.1  # and none is lost in the air


@pytest.mark.parametrize("name", MACHINES)
def test_an_upright_wheel_is_drawn_almost_down_to_the_ground(name: str) -> None:
    model = systems.get(name).model()
    gaps = lowest(model, np.zeros(model.nx)).reshape(-1, 2).min(axis=1)
    assert (gaps > 0).all()
    assert (gaps < 0.02).all()  # [m]
