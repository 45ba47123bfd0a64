"""A hand moves a yo-yo up and down, whose string winds on its axle."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Cable,
    Cylinder,
    Disk,
    Force,
    System,
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


def yoyo() -> System:
    m, R, r = parameter("m", 0.06, "kg"), parameter("R", 0.03, "m"), parameter("r", 0.005, "m")
    l, g = parameter("l", 0.9, "m"), parameter("g", 9.81, "m/s^2")  # noqa: E741
    h, z = length("h", 0.8, 1.6, speed=2.0), length("z", 0.05, 1.6, speed=3.0)
    phi = angle("phi", speed=400.0)
    hand = Body("hand", move(0, 0, h), mass=0.4, shape=Box(0.08, 0.08, 0.03))
    toy = Body(
        "toy",
        move(r, 0, z) @ rot_y(phi),
        mass=m,
        inertia=(m * R**2 / 4, m * R**2 / 2, m * R**2 / 4),
        shape=(Disk(R, thickness=0.03, axis="y"), Cylinder(r, 0.05, axis="y")),
    )
    string = closed(h - z - l / 2 - r * phi, "string")
    return System(
        "yoyo",
        bodies=[hand, toy],
        constraints=[string],
        gravity=toward("-z", g),
        inputs=[Force("lift", on=hand, along=WORLD.z, limit=(0.0, 10.0))],
        efforts=[Viscous(rate(phi), 1e-6), Viscous(rate(h), 0.5)],
        cables=[Cable((move(0, 0, h), move(0, 0, z)), "string", radius=0.001)],
    )
