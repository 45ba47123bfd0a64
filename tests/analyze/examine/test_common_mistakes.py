"""Mistakes of machines that examine points out: units, missing bodies, pairs without a name."""

from __future__ import annotations

import pytest

from kinolab.analyze.examine import examine
from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Force,
    System,
    Torque,
    Viscous,
    angle,
    length,
    move,
    rate,
    rot_y,
)
from kinolab.errors import InputError

ROD = Box(0.2, 0.02, 0.02)
UNIFORM = 0.2 * 0.2**2 / 12  # [kg m^2] of a rod of 0.2 kg and 0.2 m


def rod(inertia: float) -> System:
    q = angle("q", speed=5.0)
    hinge = rot_y(q)
    body = Body("rod", hinge @ move(0.1, 0, 0), mass=0.2, inertia=inertia, shape=ROD)
    return System("s", bodies=[body], inputs=[Torque("u", on=body, about=hinge.y, limit=1)])


def broken(system: System) -> list[str]:
    return list(examine(system).faults)


def test_an_inertia_in_g_cm2_is_too_large_for_its_body() -> None:
    """1 kg m^2 = 10^7 g cm^2: more than m r^2 no body within the radius r can have."""
    (found,) = broken(rod(1e7 * UNIFORM))
    assert "inertia too large: rod" in found
    assert "g cm^2" in found


def test_an_inertia_that_was_divided_once_too_often_is_too_small() -> None:
    (found,) = broken(rod(1e-7 * UNIFORM))
    assert "inertia too small: rod" in found
    assert "g cm^2" in found


def test_the_inertia_of_a_uniform_rod_fits() -> None:
    assert broken(rod(UNIFORM)) == []


def tip(*, listed: bool, mass: float) -> System:
    """Two rods, one behind the other; the second may be left out or have no mass."""
    q, p = angle("q", speed=5.0), angle("p", speed=5.0)
    hinge = rot_y(q)
    first = Body("rod", hinge @ move(0.1, 0, 0), mass=0.2, inertia=UNIFORM, shape=ROD)
    second = Body("tip", hinge @ move(0.2, 0, 0) @ rot_y(p) @ move(0.1, 0, 0), mass=mass, shape=ROD)
    bodies = [first, second] if listed else [first]
    motor = Torque("u", on=first, about=hinge.y, limit=1)
    return System("s", bodies=bodies, inputs=[motor], efforts=[Viscous(rate(p), 0.1)])


def test_a_moving_body_without_mass_is_named() -> None:
    with pytest.raises(InputError, match=r"motion of p\. Give 'tip' a mass or an inertia"):
        tip(listed=True, mass=0.0).model()


def test_a_body_that_was_left_out_is_missed_by_what_moves_with_it() -> None:
    with pytest.raises(InputError, match="No body moves with p: add the one that does to bodies"):
        tip(listed=False, mass=1.0).model()


def test_a_force_on_a_body_that_was_left_out_says_where_to_add_it() -> None:
    x = length("x", speed=1.0)
    listed = Body("listed", move(x, 0, 0), mass=1.0)
    other = Body("other", move(x, 1, 0), mass=1.0)
    push = Force("u", on=other, along=WORLD.x, limit=1)
    with pytest.raises(InputError, match=r"'other', which the system does not list\. Add it to"):
        System("s", bodies=[listed], inputs=[push])


def sliders(pairs: list[tuple[str, str]]) -> System:
    """Two blocks on two rails that are nearer than the blocks are wide."""
    x, y = length("x", -2, 2, speed=5.0), length("y", -2, 2, speed=5.0)
    block = Box(0.5, 0.5, 0.5)
    red = Body("red", move(x, 0, 0), mass=1.0, inertia=0.04, shape=block)
    blue = Body("blue", move(y, 0.2, 0), mass=1.0, inertia=0.04, shape=block)
    push = Force("u", on=red, along=WORLD.x, limit=1)
    return System("s", bodies=[red, blue], inputs=[push], collisions=pairs)


def test_bodies_that_pass_through_each_other_are_told_with_the_remedy() -> None:
    told = [one for one in examine(sliders([])).sentences if "collisions=" in one]
    assert len(told) == 1
    assert "red and blue" in told[0]
    assert "('red', 'blue')" in told[0]


def test_pairs_that_are_named_are_not_told() -> None:
    assert not any("collisions=" in one for one in examine(sliders([("red", "blue")])).sentences)
