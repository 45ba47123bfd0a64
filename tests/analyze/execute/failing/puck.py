"""A puck on a table that two fans push."""

from kinolab.dynamics import WORLD, Body, Cylinder, Force, System, Viscous, length, move, parameter, rate


def puck() -> System:
    """It slides along x and y, with a little drag."""
    m, c = parameter("m", 1.0, "kg"), parameter("c", 0.4, "N s/m")
    x, y = length("x", speed=2.0), length("y", speed=2.0)
    body = Body("puck", move(x, y, 0.06), mass=m, shape=Cylinder(0.15, 0.1))
    return System(
        "puck",
        bodies=[body],
        inputs=[
            Force("fan_x", on=body, along=WORLD.x, limit=1.5),
            Force("fan_y", on=body, along=WORLD.y, limit=1.5),
        ],
        efforts=[Viscous(rate(x), c), Viscous(rate(y), c)],
    )
