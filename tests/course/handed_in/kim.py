"""My drone and its load."""

from kinolab.dynamics import (
    Body,
    Box,
    Control,
    Sphere,
    System,
    Viscous,
    Wrench,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
)


def kim() -> System:
    """My drone and its load."""
    M, m = parameter("M", 1.0, "kg"), parameter("m", 0.2, "kg")
    a, l = parameter("a", 0.2, "m"), parameter("l", 0.5, "m")  # noqa: E741
    J, c = parameter("J", 0.015, "kg m^2"), parameter("c", 0.002, "N m s/rad")
    g = parameter("g", 9.81, "m/s^2")
    x, z = length("x", speed=4.0), length("z", speed=4.0)
    theta = angle("theta", -1.2, 1.2, speed=6.0)
    swing = angle("swing", -1.5, 1.5, speed=8.0)
    centre = move(x, 0, z)
    hull = centre @ rot_y(theta)
    drone = Body(
        "drone", hull, mass=M, inertia=J, shape=(Box(2 * a, 0.1, 0.04), Box(0.1, 0.1, 0.08))
    )
    hook = centre @ rot_y(swing)
    load = Body("load", hook @ move(0, 0, -l), mass=m, shape=Sphere(0.04))
    left = Control("left", limit=(0.0, 12.0), unit="N")
    right = Control("right", limit=(0.0, 12.0), unit="N")
    return System(
        "kim",
        bodies=[drone, load],
        gravity=toward("-z", g),
        inputs=[left, right],
        efforts=[
            Wrench(on=drone, force=(0, 0, left.symbol), at=(-a, 0, 0)),
            Wrench(on=drone, force=(0, 0, right.symbol), at=(a, 0, 0)),
            Viscous(rate(swing), c),
        ],
        cables=[(centre, load.frame)],
    )
