"""Two weights on a rope over a wheel."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Disk,
    System,
    Torque,
    Viscous,
    angle,
    closed,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
)


def sven() -> System:
    """A motor turns a wheel, and a rope over it holds two weights, of which one swings a rod."""
    m_1, m_2 = parameter("m_1", 2.0, "kg"), parameter("m_2", 1.5, "kg")
    w, r = parameter("w", 1.0, "kg"), parameter("r", 0.2, "m")
    b, g = parameter("b", 0.3, "kg"), parameter("g", 9.81, "m/s^2")
    z_1, z_2 = length("z_1", 0.3, 1.7, speed=2.0), length("z_2", 0.3, 1.7, speed=2.0)
    phi, swing = angle("phi", speed=10.0), angle("swing", -1.5, 1.5, speed=8.0)
    top = move(0, 0, 2.5)
    wheel = Body(
        "wheel",
        top @ rot_y(phi),
        mass=w,
        inertia=(w * r**2 / 4, w * r**2 / 2, w * r**2 / 4),
        shape=Disk(r, 0.05, axis="y"),
    )
    left, right = move(-r, 0, z_1), move(r, 0, z_2)
    one = Body("left weight", left, mass=m_1, shape=Box(0.1, 0.1, 0.1))
    two = Body("right weight", right, mass=m_2, shape=Box(0.1, 0.1, 0.1))
    rod = Body(
        "rod",
        right @ rot_y(swing) @ move(0, 0, -0.15),
        mass=b,
        inertia=(b * 0.3**2 / 12, b * 0.3**2 / 12, b * 0.02**2),
        shape=Box(0.02, 0.02, 0.3),
    )
    return System(
        "sven",
        bodies=[wheel, one, two, rod],
        constraints=[
            closed(z_1 - z_2, "the rope is as long as it was"),
            closed(z_1 - 1.0 - r * phi, "the rope does not slip"),
        ],
        inputs=[Torque("motor", on=wheel, about=WORLD.y, limit=15.0)],
        efforts=[Viscous(rate(phi), 0.05), Viscous(rate(swing), 0.01)],
        gravity=toward("-z", g),
        cables=[(top @ move(-r), left), (top @ move(r), right)],
    )
