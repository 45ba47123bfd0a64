"""Ropes: a stone on one, a winch, and what is said of those that cannot be."""

from __future__ import annotations

import re

import numpy as np
import pytest
import sympy
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from kinolab.dynamics import (
    WORLD,
    Body,
    Control,
    Drive,
    Model,
    Rope,
    System,
    acceleration,
    angle,
    length,
    move,
    parameter,
    rate,
    require,
    rot_y,
    toward,
)
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.errors import InputError
from tests.oracles.marionette import SlackStone

Array = NDArray[np.float64]

STONE = SlackStone(m=2.0, L=1.3)


def stone_on_a_rope(stiffness: float, damping: float = 0.0) -> System:
    """A stone in a vertical plane, on a rope from the origin."""
    x, z = length("x"), length("z")
    stone = Body("stone", move(x, 0, z), mass=STONE.m)
    rope = Rope(between=(WORLD, stone.frame), stiffness=stiffness, length=STONE.L, damping=damping)
    gravity = toward("-z", STONE.g)
    slack = require(-rope.stretch, "slack")
    pulling = require(rope.tension, "tension")
    requirements = [slack, pulling]
    return System(
        "stone", bodies=[stone], gravity=gravity, efforts=[rope], requirements=requirements
    )


def run(system: System, start: Array, t: Array, rtol: float = 1e-11) -> Array:
    """States at some times, shape (times, nx)."""
    model = system.model()
    solved = solve_ivp(
        lambda _, x: model.f(x),
        (0.0, float(t[-1])),
        start,
        "DOP853",
        t_eval=t,
        rtol=rtol,
        atol=rtol,
        max_step=0.01,
    )
    assert solved.success
    return np.asarray(solved.y.T)


def test_a_stone_on_a_slack_rope_falls_freely_until_it_is_taut() -> None:
    place, velocity = np.array([0.4, 0.5]), np.array([1.0, 0.3])
    end = STONE.taut_time(place, velocity)
    t = np.linspace(0, end, 9)
    path = run(stone_on_a_rope(1e5, 300.0), np.concatenate([place, velocity]), t)
    expected = [np.concatenate(STONE.flight(place, velocity, time)) for time in t]
    np.testing.assert_allclose(path, expected, rtol=0, atol=1e-9)
    model = stone_on_a_rope(1e5, 300.0).model()
    slack, tension = model.requirements(path, np.zeros((9, 0))).T
    assert (slack[:-1] > 0).all()
    assert slack[-1] == pytest.approx(0.0, abs=1e-9)
    assert (tension[:-1] == 0).all()


@pytest.mark.parametrize(("stiffness", "error"), [(1e5, 0.3), (1e7, 0.03), (1e9, 0.003)])
def test_a_stiff_rope_jerks_the_stone_and_keeps_its_moment_of_momentum(
    stiffness: float, error: float
) -> None:
    """Critically damped it lets go at t = 2 / w, w^2 = stiffness / m, with e^-2 of the speed.

    There s = v t exp(-w t) and the tension -m s_ddot vanishes. What weight and the circle's
    acceleration, 20 m/s^2 together, change until then goes with 1 / w.

    Source: Schwager, Poeschel, Coefficient of restitution and linear-dashpot model revisited,
    Granular Matter 9, 2007.
    """
    place, velocity = np.array([0.4, 0.5]), np.array([1.0, 0.3])
    end, w = STONE.taut_time(place, velocity), np.sqrt(stiffness / STONE.m)
    landed, falling = STONE.flight(place, velocity, end)
    after, impulse = STONE.tighten(landed, falling)
    damping = 2 * np.sqrt(STONE.m * stiffness)
    start, t = np.concatenate([landed, falling]), np.array([0.0, 2.5 / w])
    path = run(stone_on_a_rope(stiffness, damping), start, t, 1e-9)
    left = after - np.exp(-2) * impulse / STONE.m * landed / np.linalg.norm(landed)
    np.testing.assert_allclose(path[-1, 2:], left, rtol=0, atol=error)  # [m/s] of 4


@pytest.mark.parametrize(("stiffness", "error"), [(1e5, 1e-3), (1e7, 1e-5)])
def test_a_taut_rope_makes_a_pendulum(stiffness: float, error: float) -> None:
    """A quarter of 4 sqrt(L / g) K(sin(a / 2)), to first order in the sag 3 m g / (stiffness L)."""
    a = 0.9
    hanging = STONE.L + STONE.m * STONE.g * np.cos(a) / stiffness
    quarter = np.sqrt(STONE.L / STONE.g) * ellipk(np.sin(a / 2) ** 2)
    start = np.array([hanging * np.sin(a), -hanging * np.cos(a), 0.0, 0.0])
    path = run(stone_on_a_rope(stiffness), start, np.array([0.0, quarter]), 1e-9)
    assert path[-1, 0] == pytest.approx(0.0, abs=error)  # [m] of 1.0


def test_slack_and_taut_ropes_keep_their_energy() -> None:
    """Without damping: through free fall, a jerk that stretches the rope, and out of it again."""
    system = stone_on_a_rope(2e3)
    path = run(system, np.array([0.4, 0.5, 1.0, 0.3]), np.linspace(0, 3, 301))
    stretch = np.linalg.norm(path[:, :2], axis=1) - STONE.L
    assert (stretch > 0.01).any()
    assert (stretch < -0.01).any()
    kinetic, potential = system.model().energy(path)
    stored = 2e3 / 2 * np.maximum(stretch, 0) ** 2
    by_hand = STONE.m * (np.sum(path[:, 2:] ** 2, axis=1) / 2 + STONE.g * path[:, 1]) + stored
    np.testing.assert_allclose(kinetic + potential, by_hand, rtol=1e-12)
    assert np.ptp(by_hand) < 1e-6  # [J] of some 40, over kinks that the integrator steps across


def test_damping_takes_no_more_than_the_whole_tension() -> None:
    """k s + d s_dot, cut off at 0: in a stretched rope that shortens fast, and in a slack one."""
    k, d = 1e4, 500.0
    model = stone_on_a_rope(k, d).model()
    for s, speed in ((0.01, 0.3), (0.01, -0.1), (0.01, -0.3), (-0.01, 0.3), (-0.01, -0.3)):
        x = np.array([0.0, -(STONE.L + s), 0.0, -speed])
        tension = max(0.0, k * s + d * speed) if s > 0 else 0.0
        expected = tension / STONE.m - STONE.g
        assert model.f(x)[3] == pytest.approx(expected, abs=1e-9)
        assert model.requirements(x, ())[1] == pytest.approx(tension, abs=1e-9)


def winch() -> System:
    """A bucket on a rope over a pulley at the origin, which a drum with a drive reels in."""
    out, z = length("out", 0.5, 9.0), length("z", -9.0, 9.0)
    bucket = Body("bucket", move(0, 0, z), mass=3.0)
    drum = Body("drum", rot_y(out / 0.2), mass=1.0, inertia=0.02)
    rope = Rope(between=(WORLD, bucket.frame), stiffness=4e3, length=out, damping=60.0)
    return System(
        "winch",
        bodies=[bucket, drum],
        gravity=toward("-z", 9.81),
        inputs=[Drive("reel", on=out, limit=5.0)],
        efforts=[rope],
    )


def test_a_winch_works_against_the_tension() -> None:
    """The drive takes the drum's inertia, 0.02 / 0.2^2 = 0.5 kg, and what the rope pulls off it."""
    out, z, out_dot, z_dot, reel = 2.0, -2.01, -0.4, 0.3, 1.5
    s, s_dot = -z - out, -z_dot - out_dot
    tension = 4e3 * s + 60.0 * s_dot
    model = winch().model()
    assert model.state_names == ("out", "z", "out_dot", "z_dot")
    x = [out, z, out_dot, z_dot]
    assert model.f(x, [reel]) == pytest.approx([out_dot, z_dot, reel, tension / 3 - 9.81])
    drive = (0.5 * reel - tension) * out_dot
    assert model.power(x, [reel]) == pytest.approx(drive - 60.0 * s_dot**2, rel=1e-12)


def test_the_energy_of_a_hoisted_bucket_is_the_winchs_work() -> None:
    model = winch().model()

    def rates(_: float, both: Array) -> Array:
        return np.append(model.f(both[:-1], [-0.5]), model.power(both[:-1], [-0.5]))

    start = [3.0, -3.0 - 3 * 9.81 / 4e3, 0.0, 0.0, 0.0]
    solved = solve_ivp(rates, (0, 2), start, "DOP853", rtol=1e-11, atol=1e-11)
    energy = np.sum(model.energy(np.ascontiguousarray(solved.y[:-1].T)), axis=0)
    assert np.abs(energy - energy[0] - solved.y[-1]).max() < 1e-8  # [J]
    assert solved.y[-1, -1] > 3 * 9.81 * 0.9  # it went up by a metre


def test_a_rope_is_derived_by_hand_in_a_line() -> None:
    m, k, g = parameter("m", 2.0, "kg"), parameter("k", 1e4, "N/m"), parameter("g", 9.81, "m/s^2")
    theta, r = angle("theta"), length("r", 0.5, 3.0)
    stone = Body("stone", rot_y(theta) @ move(0, 0, -r), mass=m)
    rope = Rope(between=(WORLD, stone.frame), stiffness=k, length=1)
    system = System("sling", bodies=[stone], gravity=toward("-z", g), efforts=[rope])
    pull = k * (r - 1) * (1 + sympy.sign(r - 1)) / 2
    radial = m * (acceleration(r) - r * rate(theta) ** 2) - m * g * sympy.cos(theta) + pull
    turning = m * (r * acceleration(theta) + 2 * rate(r) * rate(theta)) + m * g * sympy.sin(theta)
    assert system.agrees_with([radial, turning])


def test_a_rope_comes_back_from_its_file() -> None:
    for system, x in (
        (winch(), [2.0, -2.01, -0.4, 0.3]),
        (stone_on_a_rope(1e4, 10.0), [0.9, -1.0, 0.5, -0.2]),
    ):
        text, u = machine_to_json(system), np.zeros(len(system.inputs))
        back = machine_from_json(text)
        assert machine_to_json(back) == text
        assert Model(back).f(x, u).tobytes() == system.model().f(x, u).tobytes()


def test_ropes_that_cannot_be_are_named_all_at_once() -> None:
    x, tug = length("x"), Control("tug", limit=1.0)
    cart = Body("cart", move(x), mass=1.0)
    wrong = [
        Rope(between=(WORLD, cart.frame), stiffness=-1.0, length=1.0),
        Rope(between=(WORLD, cart.frame), stiffness=1.0, length=1.0, damping=rate(x)),
        Rope(between=(WORLD, cart.frame), stiffness=1.0, length=1.0 + tug.symbol),
        Rope(between=(WORLD, cart.frame), stiffness=1.0, length=0.0),
    ]
    with pytest.raises(InputError) as caught:
        System("cart", bodies=[cart], inputs=[tug], efforts=wrong)
    text = str(caught.value)
    assert re.search(r"rope: its stiffness is -1\. Give 0 or more\.", text)
    assert "rope: its damping is x_dot. Give a number, or an expression of parameters." in text
    assert "rope: its length depends on tug. Take a coordinate, and a Drive on it" in text
    assert "rope: its length is 0 m. It must be positive." in text
