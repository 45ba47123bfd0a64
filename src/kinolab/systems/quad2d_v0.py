"""The planar rotor of dynobench."""

from kinolab.dynamics import (
    Body,
    Box,
    Control,
    System,
    Wrench,
    angle,
    length,
    move,
    parameter,
    rot_z,
    toward,
)


def quad2d_v0() -> System:
    """A multirotor in a vertical plane, of the size of a Crazyflie (dynobench).

    An input is a rotor's thrust relative to that in hover.

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/quad2d_v0.yaml.
    """
    m, I = parameter("m", 0.034, "kg"), parameter("I", 1e-4, "kg m^2")  # noqa: E741
    g = parameter("g", 9.81, "m/s^2")
    l = parameter("l", 0.1, "m")  # noqa: E741  # centre to rotor
    x, y, theta = length("x", speed=4.0), length("y", speed=4.0), angle("theta", speed=8.0)
    hull = move(x, y) @ rot_z(theta)
    rotor = Body("rotor", hull, mass=m, inertia=I, shape=Box(0.6, 0.2, 0.2))
    right, left = Control("f1", limit=(0.0, 1.3)), Control("f2", limit=(0.0, 1.3))
    return System(
        "quad2d_v0",
        bodies=[rotor],
        gravity=toward("-y", g),
        inputs=[right, left],
        efforts=[
            Wrench(on=rotor, force=(0, right.symbol * m * g / 2, 0), at=(l, 0, 0)),
            Wrench(on=rotor, force=(0, left.symbol * m * g / 2, 0), at=(-l, 0, 0)),
        ],
    )
