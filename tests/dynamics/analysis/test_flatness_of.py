"""What is said of flatness, of registered machines and of small ones."""

from __future__ import annotations

import pytest

from kinolab import systems
from kinolab.dynamics import (
    WORLD,
    Body,
    FlatOutputs,
    Force,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rot_y,
    toward,
)
from kinolab.dynamics.analysis.flatness_of import Flatness
from kinolab.errors import InputError


def cart_pole(mass: float = 1.0) -> System:
    x, theta = length("x"), angle("theta")
    cart = Body("cart", move(x), mass=2.0)
    pole = Body("pole", move(x) @ rot_y(theta) @ move(0, 0, 0.8), mass=mass)
    push = Force("push", on=cart, along=WORLD.x, limit=10.0)
    gravity = toward("-z", parameter("g", 9.81, "m/s^2"))
    return System("cart_pole", bodies=[cart, pole], gravity=gravity, inputs=[push])


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("rolling_disk", "flat: x and y, to their 3rd derivatives; this leaves phi free, on which"),
        ("car", "flat: x and y, to their 4th derivatives; this leaves phi free, on which nothing"),
        ("crane", "flat if friction is neglected: X, Y and Z, to their 4th derivatives (given)"),
        ("pendulum", "flat: theta, to its 2nd derivative (found)"),
        ("quad2dpole_v0", "flat: x and y of the centre of mass of pole, to their 6th derivatives"),
        (
            "quad3d_v0",
            "flat: x, y, z and the tangent of the heading of quadrotor, to their 4th, 4th,",
        ),
        ("acrobot_v0", "not flat: it has one input (tau) and static feedback does not linearise"),
        ("satellite", "not flat: no input affects 3 of its 12 dimensions"),  # its momentum
        ("snakeboard", "not known to be flat: none of "),
    ],
)
def test_registered_machines(name: str, told: str) -> None:
    assert str(systems.get(name).flatness()).startswith(told)


def test_a_pole_on_a_cart_is_not_flat() -> None:
    """Its one input does not linearise it by static feedback."""
    assert cart_pole().flatness().flatness is Flatness.NOT_FLAT


def test_the_coordinates_of_a_fully_actuated_machine_are_their_own_inverse() -> None:
    found = systems.get("five_bar").flatness()
    assert found.flatness is Flatness.FLAT
    pendulum = systems.get("pendulum").flatness().inverse
    assert isinstance(pendulum, FlatOutputs)
    assert [c.name for c in pendulum.coordinates] == ["theta"]


def test_a_machine_without_inputs_is_not_flat() -> None:
    body = Body("ball", move(length("x")), mass=1.0)
    found = System("ball", bodies=[body]).flatness()
    assert str(found) == "not flat: it has no inputs"


def test_of_inputs_that_act_alike_one_is_left() -> None:
    joint = rot_y(angle("a"))
    arm = Body("arm", joint @ move(0.5), mass=1.0)
    motors = [Torque(name, on=arm, about=joint.y, limit=1.0) for name in ("first", "second")]
    found = System("arm", bodies=[arm], inputs=motors).flatness()
    assert str(found) == ("flat: a, to its 2nd derivative; second can be anything besides (found)")


def test_a_machine_with_modes_is_asked_mode_by_mode() -> None:
    with pytest.raises(InputError, match="mode"):
        systems.get("biped").flatness()
