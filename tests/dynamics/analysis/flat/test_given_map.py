"""Flat maps that are given: those that hold pass, and each mistake is named."""

from __future__ import annotations

import pytest
import sympy

import kinolab
from kinolab import systems
from kinolab.analyze.examine.flat_map import flat_map
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.dynamics import (
    WORLD,
    Body,
    FlatOutputs,
    Force,
    PlaneCurves,
    System,
    angle,
    length,
    move,
    output,
    rot_y,
    toward,
)
from kinolab.dynamics.analysis.flat.given_map import check_flat_map
from kinolab.errors import InputError
from tests.flat_machines import pvtol

BOUNDS = {"bounds": {"x": [-5, 5], "y": [-5, 5], "z": [0, 9]}}


def cranes_map() -> FlatOutputs:
    flat = systems.get("crane").flat
    assert isinstance(flat, FlatOutputs)
    return flat


def broken_crane(k: int) -> System:
    """Return the crane with the sign of one formula of its map changed."""
    flat = cranes_map()
    pairs = list(flat.determined)
    pairs[k] = (pairs[k][0], -pairs[k][1])
    return systems.get("crane").changed(flat=FlatOutputs(flat.outputs, tuple(pairs)))


@pytest.mark.parametrize("name", ["car", "crane", "diff_drive", "rolling_disk"])
def test_registered_maps_hold(name: str) -> None:
    check_flat_map(systems.get(name).model())


@pytest.mark.parametrize("k", range(5))
def test_a_wrong_sign_is_named_with_what_is_true(k: int) -> None:
    name = cranes_map().determined[k][0].name
    with pytest.raises(InputError) as caught:
        check_flat_map(broken_crane(k).model())
    told = str(caught.value)
    assert told.startswith(f"system 'crane' flat determined {name}: in a motion of the machine")
    assert f"{name} is " in told
    assert "plan describe tells which outputs are flat" in told


def test_a_car_with_a_wrong_wheelbase_is_refused() -> None:
    car = systems.get("car")
    assert isinstance(car.flat, PlaneCurves)
    ((delta, angle),) = car.flat.steered
    (wheelbase,) = angle.free_symbols & set(car.parameters)
    wrong = PlaneCurves(
        car.flat.x, car.flat.y, car.flat.heading, ((delta, angle.subs(wheelbase, 2 * wheelbase)),)
    )
    with pytest.raises(InputError, match="flat steered delta: in a motion of the machine with x ="):
        check_flat_map(car.changed(flat=wrong).model())


def test_a_map_for_small_angles_alone_is_refused() -> None:
    """On a rope of fixed length the load rises as it swings, which X'' alone does not tell."""
    x, theta, l, g = length("x"), angle("theta", -0.5, 0.5), 2.0, 9.81  # noqa: E741
    trolley = Body("trolley", move(x), mass=4.0)
    hang = -sympy.atan(output("X", 2) / g)
    outputs = (("X", x + l * sympy.sin(theta)),)
    crane = System(
        "crane",
        bodies=[trolley, Body("load", move(x) @ rot_y(-theta) @ move(0, 0, -l), mass=1.0)],
        gravity=toward("-z", g),
        inputs=[Force("push", on=trolley, along=WORLD.x, limit=20.0)],
        flat=FlatOutputs(outputs, ((theta, hang), (x, output("X") - l * sympy.sin(theta)))),
    )
    with pytest.raises(InputError, match="flat determined theta"):
        check_flat_map(crane.model())


def test_examine_remarks_on_it() -> None:
    (remark,) = flat_map(Subject(broken_crane(0)))
    assert remark.title == "flat map that does not hold: theta_x"
    assert not list(flat_map(Subject(systems.get("crane"))))


def test_a_scenario_with_a_wrong_map_is_refused_and_one_with_a_right_map_is_not() -> None:
    tables = {"start": {"l": 5}, "goal": {"x": 1, "y": 0, "l": 5}, "world": BOUNDS}
    kinolab.load(tables | {"system": systems.get("crane")})
    with pytest.raises(InputError, match="flat determined theta_x: in a motion of the machine"):
        kinolab.load(tables | {"system": broken_crane(0)})


def test_a_centre_of_mass_is_no_flat_output_where_forces_push_it_aside() -> None:
    """It makes do with 4 of 6 dimensions; what is left are zero dynamics."""
    aircraft = pvtol()
    x, z, _ = aircraft.coordinates
    wrong = FlatOutputs((("X", x), ("Z", z)), ((x, output("X")), (z, output("Z"))))
    found = aircraft.changed(flat=wrong).flatness()
    assert not found.given
    assert "0.625 m" in str(found)
