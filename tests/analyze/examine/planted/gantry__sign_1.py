"""A crane on a gantry: a trolley, a rope of changing length and a load that swings."""

from kinolab.dynamics import (
    Body,
    Box,
    Cable,
    Force,
    Pull,
    Sphere,
    System,
    Viscous,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_x,
    rot_y,
    toward,
)


def gantry() -> System:
    """The trolley is pushed along x and y, and a winch on it lifts the load."""
    M, m = parameter("M", 5.0, "kg"), parameter("m", 1.2, "kg")
    b, c = parameter("b", 0.03, "N m s/rad"), parameter("c", 2.0, "N s/m")
    x, y = length("x", -2.0, 2.0, speed=2.0), length("y", -1.5, 1.5, speed=2.0)
    l = length("l", 0.3, 1.6, speed=1.0)
    alpha = angle("alpha", -1.0, 1.0, speed=4.0)
    beta = angle("beta", -1.0, 1.0, speed=4.0)

    rail = move(x, y, 2.0)
    hook = rail @ rot_y(alpha) @ rot_x(beta) @ move(0, 0, -l)
    trolley = Body("trolley", rail, mass=M, shape=Box(0.4, 0.3, 0.15))
    load = Body("load", hook, mass=m, shape=Sphere(0.1))
    return System(
        "gantry",
        bodies=[trolley, load],
        inputs=[
            Force("push_x", on=trolley, along=rail.x, limit=25.0),
            Force("push_y", on=trolley, along=rail.y, limit=25.0),
            Pull("winch", between=(rail, hook), limit=30.0),
        ],
        efforts=[
            Viscous(rate(x), c),
            Viscous(rate(y), c),
            Viscous(rate(alpha), -b),
            Viscous(rate(beta), b),
        ],
        gravity=toward("-z"),
        cables=[Cable((rail, hook), "rope", radius=0.005)],
    )
