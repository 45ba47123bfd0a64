"""The time as a coordinate: machines with rheonomic constraints against their closed forms."""

import numpy as np
import pytest
import sympy

from kinolab.dynamics import (
    Body,
    Force,
    Sphere,
    System,
    angle,
    clock,
    length,
    move,
    rot_y,
    toward,
    zero,
)
from kinolab.dynamics.model.second_derivation import SecondDerivation
from kinolab.dynamics.symbols.symbols import rate


def driven_pendulum() -> System:
    """A pendulum of 1 m whose pivot goes to and fro along x by 0.3 sin(2 t)."""
    theta, t = angle("theta"), clock()
    frame = move(0.3 * sympy.sin(2 * t), 0, 0) @ rot_y(theta) @ move(0, 0, -1)
    bob = Body("bob", frame, mass=1.0, shape=Sphere(0.05))
    return System("driven", bodies=[bob], gravity=toward("-z"))


def test_a_pendulum_on_a_pivot_that_is_driven() -> None:
    """Landau and Lifshitz, Mechanics, section 5, problem 3 (with their angle reversed)."""
    model = driven_pendulum().model()
    assert model.state_names == ("theta", "time", "theta_dot")
    assert model.clocks == [1]
    for theta, time, rate_ in np.random.default_rng(0).uniform(-2, 2, (50, 3)):
        pivot = -0.3 * 4 * np.sin(2 * time)
        swing = -9.81 * np.sin(theta) + pivot * np.cos(theta)
        found = model.f(np.array([theta, time, rate_]))
        np.testing.assert_allclose(found, [rate_, 1.0, swing], rtol=0, atol=1e-12)


def test_both_derivations_agree() -> None:
    model = driven_pendulum().model()
    x = np.random.default_rng(1).uniform(-2, 2, (20, 3))
    other = SecondDerivation(model).derivative(x, np.zeros((20, 0)))
    np.testing.assert_allclose(model.f(x), other, rtol=0, atol=1e-10)


def test_a_block_on_a_belt_goes_with_it() -> None:
    """A constraint that time is in: along a belt whose speed is t; across it, it slides freely."""
    x, y, t = length("x"), length("y"), clock()
    frame = move(x, y, 0)
    block = Body("block", frame, mass=2.0)
    held = zero(rate(x) - t * rate(t), "on the belt")
    push = Force("push", on=block, along=frame.y, limit=1.0)
    model = System("belt", bodies=[block], constraints=[held], inputs=[push]).model()
    state = [{"time": 0.7, "y_dot": 0.2}.get(name, 0.0) for name in model.state_names]
    found = dict(zip(model.state_names, model.f(np.array(state), [0.3]), strict=True))
    assert found == pytest.approx({"x": 0.7, "y": 0.2, "time": 1.0, "y_dot": 0.15})
