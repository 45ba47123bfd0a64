"""A charged puck on an air table in a magnetic field, pushed along x and y."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Cylinder,
    Force,
    System,
    Wrench,
    length,
    move,
    parameter,
    velocity,
)


def charged_puck() -> System:
    m, qB = parameter("m", 0.3, "kg"), parameter("qB", 0.4, "N s/m")
    x, y = length("x", speed=2.0), length("y", speed=2.0)
    at = move(x, y, 0.02)
    puck = Body("puck", at, mass=m, shape=Cylinder(0.05, 0.03))
    V = velocity(at)
    return System(
        "charged_puck",
        bodies=[puck],
        inputs=[
            Force("push_x", on=puck, along=WORLD.x, limit=1.0),
            Force("push_y", on=puck, along=WORLD.y, limit=1.0),
        ],
        efforts=[Wrench(on=puck, force=(qB * V.y, qB * V.x, 0))],
    )
