"""Machines as somebody outside wrote them in an afternoon, with the public names only."""

from __future__ import annotations

from pathlib import Path

from kinolab.dynamics import (
    Body,
    Box,
    Capsule,
    Coulomb,
    Rate,
    System,
    Torque,
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
from kinolab.dynamics.language.json.machine_file import machine_to_json

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
bounds = { x = [-2.0, 2.0], y = [-2.0, 2.0] }
ground = "plane"
[start]
x = -1.0
[goal]
x = 1.0
y = 0.5
psi = 1.57
at_rest = true
tolerance = 0.2
[integration]
step = 0.05
method = "rosenbrock"
[planner]
name = "rrt_fast"
time_limit = 40.0
improve = 0
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
    """Four wheels that cannot be steered, those of a side on one belt: to turn they must slide.

    The belts' speeds are given. Dry friction of mu N at every contact, along the tread and across
    it, is reached within about eps = 0.05 m/s of sliding: mu g / eps = 137 /s against steps of
    0.05 s.

    Source: Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots, IROS 2007
    (the geometry); Coulomb's law.
    """
    m, mu = parameter("m", 50.0, "kg"), parameter("mu", 0.7)
    eps, R = parameter("eps", 0.05, "m/s"), parameter("R", 0.11, "m")
    x, y = length("x", speed=2.0), length("y", speed=2.0)
    psi = angle("psi", speed=3.0)
    chassis = move(x, y, 0.25) @ rot_z(psi)
    body = Body("chassis", chassis, mass=m, inertia=(1.5, 3.0, 4.0), shape=Box(0.6, 0.4, 0.1))
    V, grip = velocity(chassis), mu * m * 9.81 / 4
    friction, inputs = [], []
    for side, b in (("left", 0.25), ("right", -0.25)):
        phi = angle(f"phi_{side}")
        inputs.append(Rate(side, on=phi, limit=10.0))
        for a in (0.2, -0.2):
            along = V.x - b * rate(psi) - R * rate(phi)
            across = V.y + a * rate(psi)
            friction += [Coulomb(along, grip, eps), Coulomb(across, grip, eps)]
    return System("skid_steered", bodies=[body], efforts=friction, inputs=inputs)


def written(folder: Path, machine: System, scenario: str) -> Path:
    """Write a machine and a scenario into a folder, and return the scenario's path."""
    (folder / "machine.json").write_text(machine_to_json(machine))
    (folder / "scenario.toml").write_text(scenario)
    return folder / "scenario.toml"
