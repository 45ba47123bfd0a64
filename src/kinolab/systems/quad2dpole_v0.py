"""The planar rotor with a pole of dynobench."""

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


def quad2dpole_v0() -> System:
    """A multirotor in a vertical plane that carries a point mass on a rod (dynobench).

    An input is a rotor's thrust relative to that in hover of the multirotor alone. The pole hangs
    at q = 0, measured from the multirotor.

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/quad2dpole_v0.yaml.
    """
    m, m_p = parameter("m", 2.5, "kg"), parameter("m_p", 0.25, "kg")
    I, g = parameter("I", 1.2, "kg m^2"), parameter("g", 9.81, "m/s^2")  # noqa: E741
    l, r = parameter("l", 0.25, "m"), parameter("r", 1.0, "m")  # noqa: E741  # to a rotor, to the mass
    x, y = length("x", speed=3.0), length("y", speed=3.0)
    theta, q = angle("theta", -1.570796, 1.570796, speed=5.0), angle("q", speed=5.0)
    hull = move(x, y) @ rot_z(theta)
    rotor = Body("rotor", hull, mass=m, inertia=I, shape=Box(0.5, 0.25, 0.2))
    pole = Body(
        "pole", hull @ rot_z(q) @ move(0, -r), mass=m_p, shape=Box(0.1, r, 0.1, at=(0, r / 2, 0))
    )
    right, left = Control("f1", limit=(0.0, 3.0)), Control("f2", limit=(0.0, 3.0))
    return System(
        "quad2dpole_v0",
        bodies=[rotor, pole],
        gravity=toward("-y", g),
        inputs=[right, left],
        efforts=[
            Wrench(on=rotor, force=(0, right.symbol * m * g / 2, 0), at=(l, 0, 0)),
            Wrench(on=rotor, force=(0, left.symbol * m * g / 2, 0), at=(-l, 0, 0)),
        ],
    )
