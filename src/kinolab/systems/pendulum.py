"""A pendulum with a motor at its pivot."""

from kinolab.dynamics import (
    Body,
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
