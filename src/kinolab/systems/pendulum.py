"""A pendulum with a motor at its pivot, and a double one with a motor between its links."""

from sympy import pi

from kinolab.dynamics import (
    Body,
    Box,
    Capsule,
    Sphere,
    System,
    Torque,
    angle,
    move,
    parameter,
    rot_z,
    toward,
)

THICK = 0.1  # [m] thickness of the links of the acrobot


def pendulum() -> System:
    """A point mass on a rod that a motor turns; x points down, theta = 0 hangs.

    Source: Astrom, Furuta, Swinging up a pendulum by energy control, Automatica 36(2), 2000.
    """
    m, l, g = parameter("m", 1.0, "kg"), parameter("l", 1.0, "m"), parameter("g", 9.81, "m/s^2")  # noqa: E741
    theta = angle("theta", speed=10.0)
    rod = rot_z(theta)
    shape = (Sphere(0.1), Capsule(0.02, l, axis="x", at=(-l / 2, 0, 0)))
    bob = Body("bob", rod @ move(l), mass=m, shape=shape)
    return System(
        "pendulum",
        bodies=[bob],
        gravity=toward("+x", g),
        inputs=[Torque("torque", on=bob, about=rod.z, limit=5.0)],
    )


def acrobot_v0() -> System:
    """Two links that hang from a pivot; a motor acts at the elbow (dynobench).

    At q1 = q2 = 0 both hang; q2 is relative to the first link.

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/acrobot_v0.yaml; Spong, The swing up
    control problem for the acrobot, IEEE Control Systems 15(1), 1995.
    """
    m1, m2 = parameter("m1", 1.0, "kg"), parameter("m2", 1.0, "kg")
    g = parameter("g", 9.81, "m/s^2")
    l1, l2 = parameter("l1", 1.0, "m"), parameter("l2", 1.0, "m")
    lc1, lc2 = parameter("lc1", 0.5, "m"), parameter("lc2", 0.5, "m")  # pivot to centre of mass
    I1, I2 = parameter("I1", 0.33333, "kg m^2"), parameter("I2", 0.33333, "kg m^2")  # about pivots
    q1, q2 = angle("q1", speed=8.0), angle("q2", speed=8.0)
    shoulder = rot_z(q1) @ rot_z(-pi / 2)
    elbow = shoulder @ move(l1) @ rot_z(q2)
    first = Body(
        "first link",
        shoulder @ move(lc1),
        mass=m1,
        inertia=I1 - m1 * lc1**2,
        shape=Box(l1, THICK, THICK, at=(l1 / 2 - lc1, 0, 0)),
    )
    second = Body(
        "second link",
        elbow @ move(lc2),
        mass=m2,
        inertia=I2 - m2 * lc2**2,
        shape=Box(l2, THICK, THICK, at=(l2 / 2 - lc2, 0, 0)),
    )
    return System(
        "acrobot_v0",
        bodies=[first, second],
        gravity=toward("-y", g),
        inputs=[Torque("tau", on=second, about=elbow.z, limit=10.0, reacts_on=first)],
    )
