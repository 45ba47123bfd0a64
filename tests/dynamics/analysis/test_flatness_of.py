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
    output,
    parameter,
    rot_y,
    toward,
)
from kinolab.dynamics.analysis.flatness_of import Flatness
from kinolab.errors import InputError
from tests.flat_machines import pvtol, quadrotor_with_pendulum, truck_with_two_trailers


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


@pytest.mark.parametrize("name", ["car", "diff_drive", "rolling_disk"])
def test_plane_curves_that_are_found_are_those_that_were_given(name: str) -> None:
    given = systems.get(name)
    found = given.changed(flat=None).flatness()
    assert str(found.inverse) == str(given.flat)
    assert found.inverse is not None
    assert not found.given


def test_an_aircrafts_lean_follows_from_the_acceleration_of_huygens_centre() -> None:
    """Martin, Devasia, Paden 1996: its thrust is the only force there besides weight."""
    found = pvtol().flatness().inverse
    assert isinstance(found, FlatOutputs)
    (theta, lean), *_ = found.determined
    assert theta.name == "theta"
    assert str(lean) == "atan(X''/(Z'' + g))"


def test_where_no_closed_form_is_known_there_is_no_inverse() -> None:
    for machine in (quadrotor_with_pendulum(), truck_with_two_trailers()):
        found = machine.flatness()
        assert found.outputs
        assert found.inverse is None


def test_a_map_that_is_wrong_is_no_inverse() -> None:
    x = length("x")
    cart = Body("cart", move(x), mass=1.0)
    push = Force("push", on=cart, along=WORLD.x, limit=1.0)
    for factor, holds in ((1, True), (2, False)):
        flat = FlatOutputs((("X", x),), ((x, factor * output("X")),))
        found = System("cart", bodies=[cart], inputs=[push], flat=flat).flatness()
        assert found.given
        assert (found.inverse is not None) == holds
