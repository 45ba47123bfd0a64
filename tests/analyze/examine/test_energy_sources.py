"""Friction with the wrong sign feeds energy in, and is named; friction as it should be is not."""

from __future__ import annotations

import re

import pytest
import sympy

from kinolab.analyze.examine import Remark, examine
from kinolab.dynamics import (
    WORLD,
    Body,
    Control,
    Coulomb,
    Feedback,
    Force,
    Reference,
    SlidingFriction,
    Spring,
    System,
    Viscous,
    Wrench,
    length,
    move,
    parameter,
    rate,
    rot_z,
    velocity,
)
from kinolab.dynamics.language.forces import Effort
from kinolab.errors import InputError

SPEED = 2.0  # [m/s], the limit
X, Y = length("x", -3.0, 3.0, speed=SPEED), length("y", -3.0, 3.0, speed=SPEED)
SLEDGE = Body("sledge", move(X, Y), mass=2.0, inertia=0.1)
PUSH = Force("push", on=SLEDGE, along=WORLD.x, limit=1.0)


def told(*efforts: Effort, body: Body = SLEDGE) -> list[Remark]:
    machine = System("s", bodies=[body], inputs=[PUSH], efforts=efforts)
    return list(examine(machine).remarks)


def test_a_wrench_along_the_velocity_is_friction_with_the_wrong_sign() -> None:
    """c = 3 N s/m along x: the power is 3 v^2, within half of the speed limit at most 3 W."""
    (found,) = told(Wrench(on=SLEDGE, force=(3.0 * rate(X), 0, 0)))
    assert found.kind == "friction that pushes"
    watts = re.search(
        r"wrench on body 'sledge' feeds in up to (\S+) W while all inputs", found.sentence
    )
    assert watts is not None
    assert 0.0 < float(watts[1]) <= 3.0 * (SPEED / 2) ** 2


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_drag_takes_energy_out_in_any_axes(turn: float) -> None:
    """The frame of the body is turned; its own velocity components are what the force opposes."""
    frame = move(X, Y) @ rot_z(turn)
    V, body = velocity(frame), Body("sledge", frame, mass=2.0, inertia=0.1)
    push = Force("push", on=body, along=frame.x, limit=1.0)
    drag = Wrench(on=body, force=(-3.0 * V.x, -2.0 * V.y * abs(V.y), 0))
    machine = System("s", bodies=[body], inputs=[push], efforts=[drag])
    assert examine(machine).faults == ()


def test_a_damper_between_two_bodies_counts_their_relative_velocity() -> None:
    """F = -c (v1 - v2) on one, its reaction on the other: -c (v1 - v2)^2 in all, never positive."""
    first = Body("first", move(X, 0), mass=1.0, inertia=0.1)
    second = Body("second", move(Y, 1), mass=1.0, inertia=0.1)
    push = Force("push", on=first, along=WORLD.x, limit=1.0)
    for sign, holds in ((-1, True), (1, False)):
        force = (sign * 0.5 * (rate(X) - rate(Y)), 0, 0)
        damper = Wrench(on=first, force=force, reacts_on=second)
        machine = System("s", bodies=[first, second], inputs=[push], efforts=[damper])
        assert (examine(machine).faults == ()) is holds


def test_a_coefficient_that_becomes_negative_on_the_way_is_found() -> None:
    """1 - 20 x^2 is negative beyond 0.22 m, and positions are looked at up to 1.5 m."""
    (found,) = told(Viscous(rate(X), 1.0 - 20.0 * X**2))
    assert "viscous friction of x_dot" in found.sentence
    assert told(Viscous(rate(X), 1.0 + 20.0 * X**2)) == []


def test_a_wind_is_no_friction_that_pushes() -> None:
    assert told(Wrench(on=SLEDGE, force=(0.5, 0, 0))) == []


def test_friction_that_pushes_is_found_beside_a_controller() -> None:
    speed = Reference("speed", limit=1.0, unit="m/s")
    law = Feedback([speed], {"push": speed.symbol - rate(X)})
    pushed = Wrench(on=SLEDGE, force=(3.0 * rate(X), 0, 0))
    machine = System("s", bodies=[SLEDGE], inputs=[PUSH], efforts=[pushed], feedback=law)
    assert "friction that pushes" in {one.kind for one in examine(machine).remarks}


def test_a_spring_that_pushes_its_ends_apart_is_told() -> None:
    for stiffness, kinds in ((50.0, set()), (-50.0, {"spring that pushes"})):
        spring = Spring(between=(WORLD, SLEDGE.frame), stiffness=stiffness)
        assert {one.kind for one in told(spring)} == kinds


def test_what_an_input_drives_is_no_finding() -> None:
    motor = Control("motor", limit=1.0)
    pushed = Wrench(on=SLEDGE, force=((1 + motor.symbol) * rate(X), 0, 0))
    machine = System("s", bodies=[SLEDGE], inputs=[motor], efforts=[pushed])
    assert examine(machine).faults == ()


@pytest.mark.parametrize(
    ("effort", "words"),
    [
        (Viscous(rate(X), -0.5), "viscous friction of x_dot: its coefficient is -0.5. Give 0 or"),
        (Coulomb(rate(X), -1.0), "Coulomb friction of x_dot: its strength is -1. Give 0 or more"),
        (Coulomb(rate(X), 1.0, 0.0), "Coulomb friction of x_dot: its smoothing is 0. It must be"),
        (
            SlidingFriction((rate(X), rate(Y)), -2.0),
            "sliding friction of x_dot and y_dot: its strength is -2.",
        ),
    ],
)
def test_friction_with_a_bad_number_is_refused_where_it_is_declared(
    effort: Effort, words: str
) -> None:
    with pytest.raises(InputError) as refused:
        System("s", bodies=[SLEDGE], inputs=[PUSH], efforts=[effort])
    assert words in str(refused.value)


def test_a_parameter_that_makes_friction_negative_is_refused() -> None:
    b = parameter("b", 0.2, "N s/m")
    machine = System("s", bodies=[SLEDGE], inputs=[PUSH], efforts=[Viscous(rate(X), b)])
    with pytest.raises(InputError, match=r"viscous friction of x_dot: its coefficient is -0\.2"):
        machine.with_parameters(b=-0.2)
    assert machine.with_parameters(b=0.0).number(sympy.Integer(1) * b) == 0.0
