"""Light parts beside heavy ones: what constraints hold of them is as exact as all the rest."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sympy import Integer, sin

from kinolab.dynamics import (
    Body,
    Gravity,
    Mode,
    System,
    Transition,
    angle,
    closed,
    length,
    move,
    rot_y,
    zero,
)
from kinolab.dynamics.language.frames import homogeneous, time_derivative

RATIOS = [1e-3, 1e-5, 1e-7, 1e-8, 1e-9]
SLOPE = 0.009  # [rad]


def walker(ratio: float) -> System:
    """Hip of 1 kg, two light feet at legs of 1 m, under 1 m/s^2, down a slope.

    Source: Garcia, Chatterjee, Ruina, Coleman, The simplest walking model, 1998.
    """
    x, z = length("x", speed=9.0), length("z", speed=9.0)
    a, b = angle("a", speed=9.0), angle("b", speed=9.0)
    hip = move(x, 0, z)
    feet = {name: hip @ rot_y(-q) @ move(0, 0, -1) for name, q in (("a", a), ("b", b))}
    place = {name: homogeneous(foot) for name, foot in feet.items()}
    modes, changes = [], []
    for name, other, q, p in (("a", "b", a, b), ("b", "a", b, a)):
        stands = [zero(time_derivative(place[name][k, 3]), f"{name} {'x?z'[k]}") for k in (0, 2)]
        modes.append(Mode(name, constraints=stands))
        above = place[other][2, 3] - place[name][2, 3]
        changes.append(
            Transition(f"{other} strikes", name, other, until=above, provided=sin(p) - sin(q))
        )
    return System(
        "walker",
        bodies=[
            Body("hip", hip, mass=1.0),
            *(Body("foot " + name, foot, mass=ratio) for name, foot in feet.items()),
        ],
        gravity=Gravity((math.sin(SLOPE), 0.0, -math.cos(SLOPE)), Integer(1)),
        modes=modes,
        transitions=changes,
    )


def by_hand(ratio: float, a: float, b: float, a_dot: float, b_dot: float) -> tuple[float, float]:
    """Return both legs' accelerations by Lagrange, foot a being at rest.

    The hip is at (-sin a, cos a), the swinging foot at (sin b, -cos b) from it.
    """
    g = np.array([math.sin(SLOPE), -math.cos(SLOPE)])
    hip = np.array([-math.cos(a), -math.sin(a)])
    foot = np.array([math.cos(b), math.sin(b)])
    fall_hip = np.array([math.sin(a), -math.cos(a)]) * a_dot**2
    fall_foot = fall_hip + np.array([-math.sin(b), math.cos(b)]) * b_dot**2
    M = np.array([[1 + ratio, ratio * hip @ foot], [hip @ foot, 1.0]])  # the second over the ratio
    load = [hip @ (g - fall_hip) + ratio * hip @ (g - fall_foot), foot @ (g - fall_foot)]
    return tuple(np.linalg.solve(M, load))


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("at", [(0.3, -0.1, -0.5, 0.7), (-0.4, 0.6, 0.2, -1.1)])
def test_a_walker_with_light_feet_swings_as_by_hand(
    ratio: float, at: tuple[float, float, float, float]
) -> None:
    a, b, a_dot, b_dot = at
    model = walker(ratio).model()
    known = {
        **{"x": -math.sin(a), "z": math.cos(a), "a": a, "b": b, "mode": 0.0},
        **{"x_dot": -math.cos(a) * a_dot, "z_dot": -math.sin(a) * a_dot},
        **{"a_dot": a_dot, "b_dot": b_dot},
    }
    change = model.f([known[name] for name in model.state_names], [])
    found = [change[model.state_names.index(name)] for name in ("a_dot", "b_dot")]
    assert found == pytest.approx(by_hand(ratio, *at), rel=1e-10)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("twice", [False, True])
def test_a_pendulum_on_a_light_pivot_swings_as_any(ratio: float, twice: bool) -> None:
    """1 kg hangs 0.5 m below a pivot that is held, once or in two ways: g sin a / l."""
    x, z, a = length("x", speed=9.0), length("z", speed=9.0), angle("a", speed=9.0)
    bob = move(x, 0, z)
    pivot = bob @ rot_y(a) @ move(0, 0, 0.5)
    place = homogeneous(pivot)
    held = [closed(place[k, 3], f"held along {'x?z'[k]}") for k in (0, 2)]
    if twice:
        held += [closed(place[0, 3] + 2 * place[2, 3], "held across")]
    system = System(
        "pendulum",
        bodies=[Body("bob", bob, mass=1.0), Body("pivot", pivot, mass=ratio)],
        constraints=held,
        gravity=Gravity((0.0, 0.0, -1.0), Integer(9)),
        velocities="all",
    )
    model = system.model()
    known = {
        "x": -0.5 * math.sin(0.4), "z": -0.5 * math.cos(0.4), "a": 0.4, "a_dot": 1.2,
        "x_dot": -0.5 * math.cos(0.4) * 1.2, "z_dot": 0.5 * math.sin(0.4) * 1.2,
    }  # fmt: skip
    change = model.f([known[name] for name in model.state_names], [])
    found = change[model.state_names.index("a_dot")]
    assert found == pytest.approx(-9 * math.sin(0.4) / 0.5, rel=1e-10)
