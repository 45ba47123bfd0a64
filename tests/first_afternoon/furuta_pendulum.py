"""A rotary inverted pendulum: a motor turns an arm, at whose end a pendulum swings freely."""

from math import pi

from kinolab.dynamics import (
    WORLD,
    Body,
    Capsule,
    System,
    Torque,
    Viscous,
    angle,
    move,
    parameter,
    rate,
    rot_x,
    rot_z,
    toward,
)


def furuta_pendulum() -> System:
    """A Furuta pendulum; theta is 0 where it hangs and pi where it stands."""
    m, l = parameter("m", 0.13, "kg"), parameter("l", 0.15, "m")  # noqa: E741  # half its length
    M, r = parameter("M", 0.25, "kg"), parameter("r", 0.22, "m")
    c, b = parameter("c", 2e-3, "N m s/rad"), parameter("b", 1e-4, "N m s/rad")
    alpha = angle("alpha", -pi, pi, speed=15.0)
    theta = angle("theta", speed=30.0)
    motor = move(0, 0, 0.5) @ rot_z(alpha)
    arm_shape, rod_shape = Capsule(0.01, 0.2, axis="x"), Capsule(0.006, 0.28)
    arm = Body("arm", motor @ move(r / 2, 0, 0), mass=M, inertia=M * r**2 / 12, shape=arm_shape)
    pivot = motor @ move(r, 0, 0) @ rot_x(theta)
    I = m * l**2 / 3  # noqa: E741
    rod = Body("rod", pivot @ move(0, 0, -l), mass=m, inertia=(I, I, 0), shape=rod_shape)
    return System(
        "furuta_pendulum",
        bodies=[arm, rod],
        gravity=toward("-z", 9.81),
        inputs=[Torque("motor", on=arm, about=WORLD.z, limit=0.15)],
        efforts=[Viscous(rate(alpha), c), Viscous(rate(theta), b)],
    )
