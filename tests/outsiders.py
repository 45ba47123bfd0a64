"""Machines as somebody outside wrote them in an afternoon, with the public names only."""

from __future__ import annotations

from pathlib import Path

import sympy

from kinolab.dynamics import (
    Body,
    Box,
    Capsule,
    Control,
    System,
    Torque,
    Wrench,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_x,
    rot_z,
    toward,
    velocity,
)
from kinolab.dynamics.machine_file import machine_to_json

FURUTA = """
schema = 1
title = "A Furuta pendulum swings up"
[system]
file = "machine.json"
[goal]
alpha = 3.141592653589793
at_rest = true
[goal.tolerance]
alpha = 0.1
theta_dot = 1.0
alpha_dot = 0.5
[integration]
step = 0.05
"""

SKID = """
schema = 1
title = "A skid-steered robot on a table"
[system]
file = "machine.json"
[world]
bounds = { x = [-2.0, 2.0], y = [-2.0, 2.0], z = [-0.5, 1.0] }
ground = "plane"
[start]
x = -1.0
[goal]
x = 1.0
y = 0.5
tolerance = 0.2
[integration]
step = 0.05
[planner]
name = "rrt_fast"
time_limit = 40.0
"""


def furuta() -> System:
    """An arm turned about the vertical by a motor; a pendulum hinged at its tip swings across it.

    alpha = 0 hangs.

    Source: Furuta, Yamakita, Kobayashi, Swing-up control of inverted pendulum, IECON 1991; sizes,
    masses and torque of Quanser's Qube-Servo 2 (user manual), whose motor gives 10 V / 8.4 ohm
    times 0.042 N m/A.
    """
    r, l = parameter("r", 0.085, "m"), parameter("l", 0.129, "m")  # noqa: E741
    m_arm, m = parameter("m_arm", 0.095, "kg"), parameter("m", 0.024, "kg")
    theta, alpha = angle("theta", speed=30.0), angle("alpha", speed=40.0)
    hub = rot_z(theta)
    swing = hub @ move(r, 0, 0) @ rot_x(alpha)
    I_arm, I = m_arm * r**2 / 12, m * l**2 / 12  # noqa: E741
    arm = Body(
        "arm",
        hub @ move(r / 2, 0, 0),
        mass=m_arm,
        inertia=(0, I_arm, I_arm),
        shape=Capsule(0.005, r, axis="x"),
    )
    pendulum = Body(
        "pendulum",
        swing @ move(0, 0, -l / 2),
        mass=m,
        inertia=(I, I, 0),
        shape=Capsule(0.005, l, axis="z"),
    )
    return System(
        "furuta",
        bodies=[arm, pendulum],
        gravity=toward("-z"),
        inputs=[Torque("motor", on=arm, about=hub.z, limit=0.05)],
    )


def skid_steered() -> System:
    """Four driven wheels whose treads slide on the ground, with dry friction at each contact.

    The friction of a contact is mu N v / sqrt(v^2 + eps^2) against the velocity v of the tread:
    mu g / eps = 137 /s makes it stiff at steps of 0.05 s.
    """
    m, mu = parameter("m", 50.0, "kg"), parameter("mu", 0.7, "")
    eps, R = parameter("eps", 0.05, "m/s"), 0.15
    x, y = length("x", speed=2.0), length("y", speed=2.0)
    psi = angle("psi", speed=3.0)
    chassis = move(x, y, 0.25) @ rot_z(psi)
    body = Body("chassis", chassis, mass=m, inertia=(1.5, 3.0, 4.0), shape=Box(0.7, 0.5, 0.15))
    left, right = (Control(name, limit=8.0, unit="rad/s") for name in ("left", "right"))
    normal, V = m * 9.81 / 4, velocity(chassis)
    contacts = []
    for a in (0.25, -0.25):
        for b, wheel in ((0.3, left), (-0.3, right)):
            along = V.x - b * rate(psi) - R * wheel.symbol
            across = V.y + a * rate(psi)
            share = -mu * normal / sympy.sqrt(along**2 + across**2 + eps**2)
            contacts.append(Wrench(on=body, force=(share * along, share * across, 0), at=(a, b, 0)))
    return System(
        "skid_steered",
        bodies=[body],
        efforts=contacts,
        inputs=[left, right],
    )


def written(folder: Path, machine: System, scenario: str) -> Path:
    """Write a machine and a scenario into a folder, and return the scenario's path."""
    (folder / "machine.json").write_text(machine_to_json(machine))
    (folder / "scenario.toml").write_text(scenario)
    return folder / "scenario.toml"
