"""The Whipple bicycle of the benchmark, which can be self-stable."""

from __future__ import annotations

import math

import sympy
from sympy import cos, sin

from kinolab.dynamics import (
    Body,
    Box,
    Capsule,
    Constraint,
    Coordinate,
    Cylinder,
    Frame,
    Parameter,
    Sphere,
    System,
    Torque,
    angle,
    closed,
    homogeneous,
    length,
    move,
    parameter,
    rate,
    rot_x,
    rot_y,
    rot_z,
    toward,
    velocity,
    zero,
)
from kinolab.systems._wheels import leaning_wheel

LEAN, TURN = 0.8, 0.8  # [rad] of the frame and of the handlebar at most
BLUE, CLOTH = (0.1, 0.3, 0.6), (0.55, 0.2, 0.2)
STEEL, RUBBER = (0.6, 0.6, 0.6), (0.13, 0.13, 0.15)
FORK = (  # with the handlebar, along the steering axis
    *(Cylinder(0.015, 0.66, at=(0.02, side, 0.69)) for side in (-0.06, 0.06)),
    Cylinder(0.018, 0.2, at=(0, 0, 1.0)),
    Cylinder(0.015, 0.5, axis="y", at=(0, 0, 1.08)),
)
RIDER = (  # bent forward about the saddle
    Capsule(0.13, 0.3, at=(0, 0, 0.24)),
    Sphere(0.12, at=(0.03, 0, 0.66)),
    *(
        shape
        for side in (-0.16, 0.16)
        for shape in (
            Capsule(0.04, 0.38, axis="x", at=(0.2, side, 0.4)),
            Capsule(0.065, 0.36, axis="x", at=(0.18, side / 1.6, 0)),
            Capsule(0.05, 0.38, at=(0.36, side / 1.6, -0.2)),
        )
    ),
)


def whipple() -> System:
    """A bicycle of four bodies: rear wheel, frame with rider, handlebar with fork, front wheel.

    The wheels roll on knife edges. The fork turns about a tilted axis, and the frame pitches so
    that the front wheel stays on the ground. A lean phi > 0 is to the right, a steering angle
    delta > 0 to the left; theta is the pitch, theta_R and theta_F are the wheels' rotations against
    the leaning plane and the fork. Parameters are those of the benchmark, whose axes point ahead
    (x) and down (z) from the rear contact; steering to the right is positive there.

    Source: Meijaard, Papadopoulos, Ruina, Schwab, Linearized dynamics equations for the balance
    and steer of a bicycle: a benchmark and review, Proc. R. Soc. A 463, 2007, table 1.
    """
    w, c = parameter("w", 1.02, "m"), parameter("c", 0.08, "m")
    lam = parameter("lam", math.pi / 10, "rad")
    r_R, r_F = parameter("r_R", 0.3, "m"), parameter("r_F", 0.35, "m")
    x, y, psi = length("x"), length("y"), angle("psi")  # rear contact, heading
    phi = angle("phi", -LEAN, LEAN, speed=4.0)
    theta = angle("theta", -0.4, 0.4)
    delta = angle("delta", -TURN, TURN, speed=8.0)
    theta_R, theta_F = angle("theta_R", speed=40.0), angle("theta_F")
    track = move(x, y) @ rot_z(psi)
    axle = track @ rot_x(phi) @ move(0, 0, r_R)  # leans, neither rolls nor pitches
    chassis = axle @ rot_y(theta)
    head = chassis @ move(w + c, 0, -r_R) @ rot_y(-lam)  # where the steering axis meets the ground
    fork = head @ rot_z(delta)
    upright = fork @ rot_y(lam)  # the fork's axes that are level when riding straight
    ahead, above = -c * cos(lam) + r_F * sin(lam), c * sin(lam) + r_F * cos(lam)
    front_axle = fork @ move(ahead, 0, above)
    frame, handlebar = _frame(chassis, r_R), _handlebar(upright, w + c)
    saddle = chassis @ move(0.24, 0, 0.6) @ rot_y(0.5)
    drawn = (
        Body("fork", fork, shape=FORK, color=STEEL),
        Body("rider", saddle, shape=RIDER, color=CLOTH),
    )
    rear_wheel = _wheel("rear wheel", "R", axle @ rot_y(theta_R), r_R, (2.0, 0.0603, 0.12))
    front_wheel = _wheel("front wheel", "F", front_axle @ rot_y(theta_F), r_F, (3.0, 0.1405, 0.28))
    V = velocity(track)
    return System(
        "whipple",
        bodies=[rear_wheel, frame, handlebar, front_wheel, *drawn],
        gravity=toward("-z", parameter("g", 9.81, "m/s^2")),
        constraints=[
            zero(V.x - r_R * rate(theta_R), "the rear wheel rolls"),
            zero(V.y, "no sideslip behind"),
            *_on_ground(front_axle, theta_F, r_F),
        ],
        inputs=[
            Torque("drive", on=rear_wheel, about=axle.y, reacts_on=frame, limit=60.0),
            Torque("steer", on=handlebar, about=head.z, reacts_on=frame, limit=20.0),
        ],
        velocities=[phi, delta, theta_R],
    )


def _on_ground(axle: Frame, turn: Coordinate, radius: Parameter) -> tuple[Constraint, ...]:
    """Keep a wheel's lowest point on the ground, without slip ahead or along its axle.

    The axle is the frame's y axis. Seen in the frame, up is (a, b, c), of which s, the cosine of
    the lean, is across the axle. The lowest point is at -radius (a, 0, c) / s, and its path leads
    along (c, 0, -a) / s, which is level. The spin about the axle moves it along its path alone.
    """
    g, V = homogeneous(axle), velocity(axle)
    a, _, c = g[2, :3]
    s = sympy.sqrt(a**2 + c**2)
    spin = V.wy + rate(turn)
    return (
        closed(g[2, 3] - radius * s, "the front wheel touches the ground"),
        zero((c * V.x - a * V.z) / s - radius * spin, "the front wheel rolls"),
        zero(V.y - radius * (a * V.wz - c * V.wx) / s, "no sideslip in front"),
    )


def _wheel(
    name: str, letter: str, frame: Frame, radius: Parameter, values: tuple[float, float, float]
) -> Body:
    """Return a wheel with its mass in [kg] and moments across and about its axle in [kg m^2]."""
    mass, across, about = values
    I_xx = parameter(f"I_{letter}xx", across, "kg m^2")
    I_yy = parameter(f"I_{letter}yy", about, "kg m^2")
    return Body(
        name,
        frame,
        mass=parameter(f"m_{letter}", mass, "kg"),
        inertia=(I_xx, I_yy, I_xx),
        # of a tyre of 3 cm, leaning by 1.1 rad at most: it is steered about a tilted axis
        shape=leaning_wheel(radius, 0.03, 1.1),
        touches_ground=True,
        color=RUBBER,
    )


def _frame(chassis: Frame, r_R: Parameter) -> Body:
    """Return the frame with its rigidly attached rider, whose shape is a body of its own."""
    x_B, z_B = parameter("x_B", 0.3, "m"), parameter("z_B", -0.9, "m")
    return Body(
        "frame",
        chassis @ move(x_B, 0, -z_B - r_R),
        mass=parameter("m_B", 85.0, "kg"),
        inertia=_moments("B", 9.2, 11.0, 2.8, 2.4),
        shape=(
            Cylinder(0.018, 0.55, axis="x", at=(-0.03, 0, -0.6)),
            Cylinder(0.018, 0.5, axis="x", at=(0.22, 0, -0.1)),
            Cylinder(0.018, 0.6, at=(-0.04, 0, -0.32)),
            Box(0.26, 0.14, 0.05, at=(-0.06, 0, 0)),
        ),
        color=BLUE,
    )


def _handlebar(upright: Frame, foot: sympy.Expr) -> Body:
    """Return the handlebar assembly; ``foot`` is where its axis meets the ground."""
    x_H, z_H = parameter("x_H", 0.9, "m"), parameter("z_H", -0.7, "m")
    return Body(
        "handlebar",
        upright @ move(x_H - foot, 0, -z_H),
        mass=parameter("m_H", 4.0, "kg"),
        inertia=_moments("H", 0.05892, 0.06, 0.00708, -0.00756),
    )


def _moments(letter: str, *values: float) -> tuple[sympy.Expr, ...]:
    """Return a body's inertia; turning z from down to up changes the sign of the xz entry."""
    names = (f"I_{letter}{axes}" for axes in ("xx", "yy", "zz", "xz"))
    xx, yy, zz, xz = (
        parameter(name, value, "kg m^2") for name, value in zip(names, values, strict=True)
    )
    return xx, yy, zz, sympy.Integer(0), -xz, sympy.Integer(0)
