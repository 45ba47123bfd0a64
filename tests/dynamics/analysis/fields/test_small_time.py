"""Controllability in small time: what Sussmann's condition says of systems that are known.

Sources:
    Sussmann, SIAM J. Control and Optimization 25(1), 1987: bad brackets, and examples.
    Lewis, Murray, Configuration controllability of simple mechanical control systems, SIAM J.
        Control and Optimization 35(3), 1997: a body with one force off its centre is not
        controllable, one with two is.
"""

from __future__ import annotations

import pytest
import sympy as sp

from kinolab import systems
from kinolab.dynamics import (
    Body,
    Force,
    SmallTime,
    System,
    Torque,
    VectorFields,
    angle,
    growth_vector,
    length,
    move,
    rot_z,
    small_time_controllability,
    vector_fields,
)
from kinolab.errors import InputError
from tests.machines import kinematic_car, wheeled_hull

x, y, z, w = sp.symbols("x y z w", real=True)


def test_a_square_pushes_one_way_only() -> None:
    """x_dot = u, y_dot = x^2 never decreases y: [u, [drift, u]] points along y and is bad."""
    fields = VectorFields.of((x, y), {"u": (1, 0)}, drift=(0, x**2))
    found = small_time_controllability(fields, {})
    assert found.outcome is SmallTime.ONE_WAY
    assert found.controllable is False
    assert found.obstacle == ("u", "drift", "u")


@pytest.mark.parametrize("exact", [False, True])
def test_pushes_of_two_inputs_may_be_opposite(exact: bool) -> None:
    """z_dot = x^2 - y^2 goes both ways: [u, [drift, u]] + [v, [drift, v]] vanishes."""
    inputs = {"u": (1, 0, 0), "v": (0, 1, 0)}
    fields = VectorFields.of((x, y, z), inputs, drift=(0, 0, x**2 - y**2))
    found = small_time_controllability(fields, {}, exact=exact)
    assert (found.outcome, found.degree) == (SmallTime.BRACKETS, 3)


def test_pushes_of_two_inputs_may_add_up() -> None:
    """z_dot = x^2 + 2 y^2 only rises, and so does what is left of x^2 - 2 y^2 in the sum."""
    inputs = {"u": (1, 0, 0), "v": (0, 1, 0)}
    for factor in (2, -2):
        fields = VectorFields.of((x, y, z), inputs, drift=(0, 0, x**2 + factor * y**2))
        assert small_time_controllability(fields, {}).outcome is SmallTime.UNDECIDED


@pytest.mark.parametrize("exact", [False, True])
def test_a_cube_pushes_both_ways(exact: bool) -> None:
    """x_dot = u, y_dot = x^3: good brackets of four fields, though not linearly controllable."""
    fields = VectorFields.of((x, y), {"u": (1, 0)}, drift=(0, x**3))
    found = small_time_controllability(fields, {}, exact=exact)
    assert (found.outcome, found.degree) == (SmallTime.BRACKETS, 4)


def test_what_the_linearisation_controls_is_controllable_whatever_is_bad() -> None:
    """x_dot = y + x^2, y_dot = u."""
    fields = VectorFields.of((x, y), {"u": (0, 1)}, drift=(y + x**2, 0))
    assert small_time_controllability(fields, {}).outcome is SmallTime.LINEAR


def test_without_drift_brackets_that_span_suffice() -> None:
    found = small_time_controllability(vector_fields(kinematic_car()), {"delta": 0.2})
    assert (found.outcome, found.degree) == (SmallTime.DRIFTLESS, 3)
    assert found.controllable


def test_a_coin_gets_to_all_states_near_rest() -> None:
    """By brackets of six fields: twice those of three that its configurations need."""
    found = small_time_controllability(vector_fields(systems.get("rolling_disk")), {"psi": 0.4})
    assert (found.outcome, found.degree) == (SmallTime.BRACKETS, 6)


def test_a_coin_that_rolls_does_not_stay() -> None:
    fields = vector_fields(systems.get("rolling_disk"))
    found = small_time_controllability(fields, {"phi_dot": 1.0})
    assert found.outcome is SmallTime.MOVING


def test_what_momentum_forbids_is_out_of_reach() -> None:
    found = small_time_controllability(vector_fields(wheeled_hull()), {})
    assert found.outcome is SmallTime.UNREACHABLE
    assert found.controllable is False


def test_a_robot_that_cannot_stop_is_not_judged() -> None:
    fields = vector_fields(systems.get("unicycle1_v1"))
    limits = {"v": (0.25, 0.5), "w": (-0.5, 0.5)}
    found = small_time_controllability(fields, {}, limits=limits)
    assert found.outcome is SmallTime.ONE_SIDED


def hovercraft(ahead: float, *, torque: bool) -> System:
    """A body in the plane with a force across it, so far ahead of its centre; a torque too."""
    frame = move(length("px"), length("py")) @ rot_z(angle("th"))
    hull = Body("hull", frame, mass=1.0, inertia=(1.0, 1.0, 0.5))
    nose = Body("nose", frame @ move(ahead))
    push = Force("push", on=nose, along=frame.y, limit=1.0)
    turn = Torque("turn", on=hull, about=frame.z, limit=1.0)
    return System("hovercraft", bodies=[hull, nose], inputs=[push, turn] if torque else [push])


def test_one_force_ahead_of_the_centre_pushes_back_only() -> None:
    """Lewis and Murray, 1997: [push, [drift, push]] is centrifugal."""
    found = small_time_controllability(vector_fields(hovercraft(0.3, torque=False)), {})
    assert found.outcome is SmallTime.ONE_WAY
    assert found.obstacle == ("push", "drift", "push")


def test_a_force_at_the_centre_and_a_torque_get_everywhere() -> None:
    """Lewis and Murray, 1997: neither pushes one way, and together they push ahead."""
    found = small_time_controllability(vector_fields(hovercraft(0.0, torque=True)), {})
    assert (found.outcome, found.degree) == (SmallTime.BRACKETS, 4)


def test_a_kink_has_no_brackets() -> None:
    """y_dot = x^2 |x| has no third derivative at 0, by which its brackets would decide."""
    fields = VectorFields.of((x, y), {"u": (1, 0)}, drift=(0, x**2 * abs(x)))
    assert small_time_controllability(fields, {}).outcome is SmallTime.KINKED
    with pytest.raises(InputError, match="the vector fields have a kink at this state"):
        growth_vector(fields, {})
    assert growth_vector(fields, {"x": 0.1}) == (2,)


def test_what_takes_too_much_work_is_said() -> None:
    fields = vector_fields(systems.get("snakeboard"))
    found = small_time_controllability(fields, {}, work=3_000_000)
    assert found.outcome is SmallTime.UNFINISHED


def test_a_held_input_belongs_to_the_drift() -> None:
    """A quadrotor hovers with its rotors at half of their thrust, and is linearly controllable."""
    robot = systems.get("quad2d_v0")
    names = [entry.name for entry in robot.inputs]
    fields = vector_fields(robot)
    assert small_time_controllability(fields, {}).outcome is SmallTime.MOVING
    found = small_time_controllability(fields, {}, dict.fromkeys(names, 1.0))
    assert found.outcome is SmallTime.LINEAR
