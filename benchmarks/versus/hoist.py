"""A trolley that hoists a load, as the C++ side of the comparison has it, frame by frame."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Force,
    Pull,
    System,
    angle,
    length,
    move,
    rot_y,
    toward,
)

HEIGHT = 5.0  # [m] of the rail
GRAVITY = 9.81  # [m/s^2]
TROLLEY, LOAD = 10.0, 5.0  # [kg]


def hoist() -> System:
    """A load on a rope below a trolley, in a plane; both are driven by forces."""
    x = length("x", 0.0, 10.0, speed=3.0)
    l = length("l", 0.5, 4.5, speed=2.0)  # noqa: E741
    theta = angle("theta", -1.0, 1.0, speed=2.0)
    rail = move(x, 0, HEIGHT)
    rope = rail @ rot_y(-theta) @ move(0, 0, -l)
    weight = LOAD * GRAVITY
    trolley = Body("trolley", rail, mass=TROLLEY)
    return System(
        "hoist",
        bodies=[Body("load", rope, mass=LOAD, shape=Box(0.6, 0.6, 0.6)), trolley],
        gravity=toward("-z", GRAVITY),
        inputs=[
            Force("travel", on=trolley, along=WORLD.x, limit=20.0),
            Pull("hoist", between=(rail, rope), limit=(weight - 15.0, weight + 15.0)),
        ],
    )
