"""A trolley on a rail with a load on a rope."""

from kinolab.dynamics import (
    Body, Box, Cable, Force, Sphere, System, Viscous, angle, length, move, parameter, rate, rot_y, toward,
)


def crane() -> System:
    """The trolley is pushed, the load swings."""
    M, m = parameter("M", 3.0, "kg"), parameter("m", 1.0, "kg")
    l = parameter("l", 1.0, "m")
    x, theta = length("x", -1.0, 4.0, speed=2.0), angle("theta", -1.0, 1.0, speed=4.0)
    rail = move(x, 0, 2.0)
    hook = rail @ rot_y(-theta) @ move(0, 0, -l)  # theta > 0: the load is ahead
    trolley = Body("trolley", rail, mass=M, shape=Box(0.3, 0.2, 0.1))
    load = Body("load", hook, mass=m, shape=Sphere(0.1))
    return System(
        "crane",
        bodies=[trolley, load],
        inputs=[Force("push", on=trolley, along=rail.x, limit=15.0)],
        efforts=[Viscous(rate(x), 0.5), Viscous(rate(theta), 0.02)],
        gravity=toward("-z"),
        cables=[Cable((rail, hook), "rope", radius=0.005)],
    )
