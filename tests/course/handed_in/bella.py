"""A motor turns a flywheel through a flexible shaft to a load, which turns a fan behind a second shaft."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Disk,
    System,
    Torque,
    Wrench,
    angle,
    move,
    parameter,
    rot_x,
)


def flexible_shaft() -> System:
    J, k = parameter("J", 0.02, "kg m^2"), parameter("k", 8.0, "N m")
    a, b, c = (
        angle("a", -20, 20, speed=20.0),
        angle("b", -20, 20, speed=20.0),
        angle("c", -20, 20, speed=20.0),
    )
    drive = Body(
        "drive", rot_x(a), mass=4.0, inertia=(J, J / 2, J / 2), shape=Disk(0.1, 0.02, axis="x")
    )
    load = Body(
        "load",
        move(0.5) @ rot_x(b),
        mass=4.0,
        inertia=(J, J / 2, J / 2),
        shape=Disk(0.1, 0.02, axis="x"),
    )
    fan = Body(
        "fan",
        move(1.0) @ rot_x(c),
        mass=4.0,
        inertia=(J, J / 2, J / 2),
        shape=Disk(0.1, 0.02, axis="x"),
    )
    return System(
        "flexible_shaft",
        bodies=[drive, load, fan],
        inputs=[Torque("motor", on=drive, about=WORLD.x, limit=5.0)],
        efforts=[
            Wrench(on=drive, torque=(-k * (a - b), 0, 0)),
            Wrench(on=load, torque=(k * (a - b) - k * (b - c), 0, 0)),
            Wrench(on=fan, torque=(k * (a - c), 0, 0)),
        ],
    )
