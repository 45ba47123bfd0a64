"""Speeds that are states: a machine that is moved, and whose acceleration is decided."""

import json

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

from kinolab.dynamics import (
    Body,
    Control,
    State,
    System,
    angle,
    lag,
    length,
    move,
    rate,
    rot_z,
    velocity,
    zero,
)
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.errors import InputError

PUSH, TURN = Control("push", limit=1.0), Control("turn", limit=1.0)


def skater() -> System:
    x, y, psi = length("x"), length("y"), angle("psi")
    frame = move(x, y) @ rot_z(psi)
    V = velocity(frame)
    speed = State("speed", PUSH.symbol, velocity=V.x, unit="m/s")
    spin = State("spin", TURN.symbol, velocity=rate(psi), unit="rad/s")
    return System(
        "skater",
        bodies=[Body("skate", frame)],
        constraints=[zero(V.y, "edge")],
        inputs=[PUSH, TURN],
        states=[speed, spin],
    )


def test_the_machine_moves_at_the_speeds_that_are_its_states() -> None:
    """Against the path by quadrature of its heading, psi = w t + a t^2 / 2."""
    model = skater().model()
    assert model.state_names == ("x", "y", "psi", "speed", "spin")
    v, w, push, turn = 0.7, -0.4, 0.3, 0.9
    x = np.array([0.0, 0.0, 0.0, v, w])
    np.testing.assert_allclose(model.velocity(x), [v, 0, w], atol=1e-15)
    run = solve_ivp(lambda _, x: model.f(x, [push, turn]), (0, 2), x, rtol=1e-11, atol=1e-12)
    s = np.linspace(0, 2, 20_001)
    heading = w * s + turn * s**2 / 2
    ahead = (v + push * s) * np.array([np.cos(heading), np.sin(heading)])
    np.testing.assert_allclose(run.y[:2, -1], np.trapezoid(ahead, s), atol=1e-8)  # of the rule
    np.testing.assert_allclose(run.y[3:, -1], [v + 2 * push, w + 2 * turn], atol=1e-9)


def test_a_speed_may_follow_its_command_with_a_lag() -> None:
    x = length("x")
    command = Control("command", limit=1.0)
    behind = lag("speed", command.symbol, 0.5)
    speed = State("speed", behind.derivative, velocity=rate(x))
    model = System("cart", bodies=[Body("b", move(x))], inputs=[command], states=[speed]).model()
    np.testing.assert_allclose(model.f([0, 0.2], [1.0]), [0.2, 1.6])


def test_the_equations_say_what_the_state_moves() -> None:
    equations = skater().equations()
    speed = sympy.Symbol("speed", real=True)
    assert [str(equation.rhs) for equation in equations.constraints] == ["0", "speed", "spin"]
    assert not equations.balance
    assert {str(equation.lhs) for equation in equations.further} == {"speed_dot", "spin_dot"}
    assert str(speed) in equations.text()


def test_what_has_mass_is_not_moved_at_a_speed_that_is_a_state() -> None:
    x, swing = length("x"), angle("swing")
    bob = Body("bob", move(x) @ rot_z(swing) @ move(1), mass=1.0)
    speed = State("speed", PUSH.symbol, velocity=rate(x))
    cart = System("cart", bodies=[bob], inputs=[PUSH], states=[speed])
    with pytest.raises(InputError) as caught:
        cart.model()
    assert str(caught.value) == (
        "state 'speed': it is the speed of a machine that has mass. "
        "Make it a Drive, whose value is the acceleration."
    )


def test_a_velocity_that_is_none_is_an_error() -> None:
    x = length("x")
    speed = State("speed", PUSH.symbol, velocity=x)
    with pytest.raises(InputError, match=r"state 'speed': (no rate|it does not vanish)"):
        System("cart", bodies=[Body("b", move(x))], inputs=[PUSH], states=[speed]).model()


def test_machines_with_states_from_before_they_had_velocities_are_read() -> None:
    text = machine_to_json(skater())
    assert machine_to_json(machine_from_json(text)) == text
    data = json.loads(text)
    for state in data["states"]:
        del state["velocity"]
    assert machine_from_json(json.dumps(data)).states[0].velocity is None
