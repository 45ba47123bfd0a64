"""Mistakes of machines that examine points out: units, missing bodies, pairs without a name."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from sympy import sin

from kinolab.analyze.examine import examine
from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Force,
    Load,
    Potential,
    Sphere,
    System,
    Torque,
    Viscous,
    Wrench,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
    zero,
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


def swinging(
    effort: Callable[[Any], Any] | None = None, inertia: Any = (0.0005, 0.0025, 0.0025)
) -> System:
    """A plate that slides along a boom, which turns in a vertical plane."""
    q, r = angle("q", speed=5.0), length("r", 0.1, 0.5, speed=2.0)
    m, g = parameter("m", 0.6, "kg"), parameter("g", 9.81, "m/s^2")
    boom = rot_y(q)
    plate = Body("plate", boom @ move(r), mass=m, inertia=inertia, shape=Box(0.2, 0.1, 0.01))
    parts = SimpleNamespace(plate=plate, q=q, r=r, weight=m * g, m=m, turn=rate(q), out=rate(r))
    return System(
        "s",
        bodies=[plate],
        inputs=[Torque("u", on=plate, about=boom.y, limit=2)],
        efforts=[] if effort is None else [effort(parts)],
        gravity=toward("-z", g),
    )


@pytest.mark.parametrize(
    ("effort", "title"),
    [
        (lambda s: Potential(1 - s.weight * s.r * sin(s.q)), "weight"),
        (lambda s: Load(s.weight * sin(s.q), s.out), "weight"),
        (lambda s: Wrench(on=s.plate, force=(s.m * s.r * s.turn**2, 0, 0)), "inertial force"),
        (lambda s: Load(-2 * s.m * s.r * s.out * s.turn, s.turn), "inertial force"),
    ],
)
def test_a_force_that_follows_from_frames_and_gravity_is_not_to_be_added(
    effort: Callable[[Any], Any], title: str
) -> None:
    """L has m r^2 q_dot^2 / 2 and m g r sin(q): all these are in its equations already."""
    found = broken(swinging(effort))
    assert any(f"{title} that is there twice: plate" in remark for remark in found)


@pytest.mark.parametrize(
    "effort",
    [
        lambda s: Potential(s.weight * s.r * sin(s.q)),  # a counterweight
        lambda s: Potential(-0.9 * s.weight * s.r * sin(s.q)),  # a load that is no body
        lambda s: Load(-0.3 * s.turn * abs(s.turn), s.turn),
        lambda s: Potential(30 * (s.r - 0.2) ** 2 + 4 * s.q**2),
    ],
)
def test_forces_of_their_own_get_no_remark(effort: Callable[[Any], Any]) -> None:
    assert broken(swinging(effort)) == []


def test_moments_of_inertia_in_another_order_are_named() -> None:
    """A plate of 0.2 m by 0.1 m by 0.01 m has m (b^2 + c^2) / 12 = 0.0005 kg m^2 about x."""
    m, a, b, c = 0.6, 0.2, 0.1, 0.01
    right = tuple(m * (a**2 + b**2 + c**2 - edge**2) / 12 for edge in (a, b, c))
    assert broken(swinging(inertia=right)) == []
    heavy = tuple(m * 0.999 * (a**2 + b**2 + c**2 - edge**2) / 4 for edge in (a, b, c))
    assert broken(swinging(inertia=heavy)) == []  # all of it in the corners
    (found,) = broken(swinging(inertia=(heavy[1], heavy[0], heavy[2])))
    assert "inertia in another order: plate" in found


def test_a_hand_that_opens_and_a_ball_under_its_rider_get_no_remark() -> None:
    """Fingers touch where they are closed; a ball's middle stays where its rider has it."""
    x, s = length("x", speed=1.0), length("s", 0.0, 0.1, speed=1.0)
    fingers = [
        Body(name, move(x, way * (0.01 + s)), mass=0.1, shape=Box(0.1, 0.02, 0.02))
        for name, way in (("left", 1), ("right", -1))
    ]
    push = Force("push", on=fingers[0], along=WORLD.x, limit=1.0)
    assert broken(System("hand", bodies=fingers, inputs=[push])) == []

    turn, lean, g = angle("turn", speed=9.0), angle("lean", -1.0, 1.0, speed=3.0), 9.81
    middle = rot_y(-0.1) @ move(x, 0, 0.1)
    ball = Body("ball", middle @ rot_y(turn), mass=2.0, inertia=0.008, shape=Sphere(0.1))
    seat = middle @ rot_y(lean) @ move(0, 0, 0.4)
    rider = Body("rider", seat, mass=5.0, inertia=0.2, shape=Box(0.1, 0.1, 0.6))
    motor = Torque("motor", on=ball, about=WORLD.y, limit=5.0, reacts_on=rider)
    rolling = zero(rate(x) - 0.1 * rate(turn), "rolling")
    assert (
        broken(
            System(
                "ballbot",
                bodies=[ball, rider],
                constraints=[rolling],
                inputs=[motor],
                gravity=toward("-z", g),
            )
        )
        == []
    )
