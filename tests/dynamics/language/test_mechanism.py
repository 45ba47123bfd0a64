"""A machine as frozen data."""

import pytest
import sympy

import kinolab.systems
from kinolab.dynamics import Body, System, angle, length, move, rot_z
from kinolab.errors import UnknownNameError

X, Y, TH = length("x"), length("y"), angle("th")


def ball() -> Body:
    return Body("ball", move(X, Y) @ rot_z(TH), mass=1, inertia=0.1)


def test_one_number_of_inertia_stands_for_three_equal_moments() -> None:
    assert ball().inertia_matrix == sympy.diag(0.1, 0.1, 0.1)
    principal = Body("ball", move(X), mass=1, inertia=(0.1, 0.1, 0.1))
    assert principal.inertia == Body("ball", move(X), mass=1, inertia=0.1).inertia


def test_coordinates_come_in_the_order_they_were_made_unless_listed() -> None:
    assert System("s", bodies=[ball()]).coordinates == (X, Y, TH)
    listed = System("s", bodies=[ball()], coordinates=[TH, Y, X])
    assert listed.coordinates == (TH, Y, X)
    assert listed.model().state_names[:3] == ("th", "y", "x")


def test_parameters_are_replaced_in_a_copy() -> None:
    system = kinolab.systems.get("rolling_disk")
    other = system.with_parameters(R=0.5)
    rest = {"g": 9.81, "mu": 0.6}
    assert system.parameter_values == {"R": 0.25, "m": 1.0, **rest}
    assert other.parameter_values == {"R": 0.5, "m": 1.0, **rest}
    assert other.with_parameters(m=3.0).parameter_values == {"R": 0.5, "m": 3.0, **rest}


def test_systems_are_found_by_name() -> None:
    assert {"pendulum", "rolling_disk"} <= set(kinolab.systems.names())
    with pytest.raises(UnknownNameError, match="Did you mean 'pendulum'"):
        kinolab.systems.get("pendlum")
    assert kinolab.systems.summary("pendulum").endswith(".")
