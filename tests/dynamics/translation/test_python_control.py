"""python-control gets linearised machines, and its gains come back as feedback."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from kinolab import systems
from kinolab.dynamics import (
    Body,
    Force,
    System,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
)
from kinolab.errors import InputError

control = pytest.importorskip("control")

M, POLE, LENGTH, G = 2.0, 0.5, 1.0, 9.81


def cart_pole() -> System:
    """A point on a rod above a cart: the textbook's."""
    x, theta = length("x", -5, 5, speed=5.0), angle("theta", -1.5, 1.5, speed=5.0)
    joint = move(x, 0, 0.2)
    cart = Body("cart", joint, mass=M)
    bob = Body("bob", joint @ rot_y(theta) @ move(0, 0, LENGTH), mass=POLE)
    push = Force("push", on=cart, along=joint.x, limit=100.0)
    return System(
        "cart_pole", bodies=[cart, bob], gravity=toward("-z", parameter("g", G)), inputs=[push]
    )


def test_the_linearisation_of_a_cart_pole_is_that_of_the_textbook() -> None:
    """Astrom, Murray, Feedback Systems, 2008, example 6.7, for a point mass without friction."""
    system = cart_pole().to_control(np.zeros(4))
    assert isinstance(system, control.StateSpace)
    A, B = np.zeros((4, 4)), np.zeros((4, 1))
    A[0, 2] = A[1, 3] = 1.0
    A[2, 1], A[3, 1] = -POLE * G / M, (M + POLE) * G / (M * LENGTH)
    B[2, 0], B[3, 0] = 1 / M, -1 / (M * LENGTH)
    assert np.abs(system.A - A).max() < 1e-12
    assert np.abs(system.B - B).max() < 1e-12
    assert system.state_labels == ["x", "theta", "x_dot", "theta_dot"]
    assert system.input_labels == ["push"]
    assert np.array_equal(system.C, np.eye(4))


def test_parameters_are_changed_by_name() -> None:
    system = cart_pole().to_control(np.zeros(4), g=1.62)
    assert system.A[3, 1] == pytest.approx((M + POLE) * 1.62 / (M * LENGTH))


def test_a_gain_of_python_control_comes_back_as_feedback() -> None:
    """The closed loop has the poles that python-control places, to first order in a step."""
    plant = cart_pole()
    linear = plant.to_control(np.zeros(4))
    gain = control.place(linear.A, linear.B, [-1.0, -1.5, -2.0, -2.5])
    held = plant.with_gain(gain, np.zeros(4), references={"x": (-3, 3)})
    model = held.model()
    assert model.control_names == ("x_set",)
    nudge = np.array([0.01, -0.02, 0.03, 0.04])
    assert model.plant_inputs(nudge, [0.0]) == pytest.approx(-gain @ nudge)
    assert model.plant_inputs(nudge, [1.0]) == pytest.approx(-gain @ (nudge - [1, 0, 0, 0]))
    closed = np.linalg.eigvals(model.jacobian(np.zeros(4), [0.0])[0])
    assert np.sort(closed.real) == pytest.approx([-2.5, -2.0, -1.5, -1.0], abs=1e-6)


def test_the_machine_under_a_gain_balances_and_goes_where_it_is_told() -> None:
    plant = cart_pole()
    linear = plant.to_control(np.zeros(4))
    gain, _, _ = control.lqr(linear, np.diag([1.0, 10.0, 1.0, 1.0]), np.eye(1))
    held = plant.with_gain(gain, np.zeros(4), references={"x": (-3, 3)})
    start = {"theta": 0.1}
    motion = kinolab.simulate(held, lambda *_: [1.0], duration=20.0, start=start, step=0.02)
    assert motion.x[-1] == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=1e-3)
    fallen = kinolab.simulate(plant, duration=1.0, start=start, step=0.02)
    assert fallen.x[-1, 1] > 0.5


def test_what_does_not_fit_is_named_at_once() -> None:
    with pytest.raises(InputError) as caught:
        cart_pole().with_gain(np.zeros((2, 4)), np.zeros(3), references={"y": 1.0})
    text = str(caught.value)
    assert "with_gain gain: it has shape (2, 4); it must be (1, 4)" in text
    assert "with_gain x: it has shape (3,); it must be (4,)" in text
    assert "no state is called 'y'" in text
    with pytest.raises(InputError, match="Name states whose set points planners choose"):
        cart_pole().with_gain(np.zeros((1, 4)), np.zeros(4), references={})
    assert rate(systems.get("pendulum").coordinates[0])
