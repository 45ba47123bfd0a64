"""A bell on a cart."""

from kinolab.dynamics import (
    Body,
    Box,
    Force,
    Sphere,
    System,
    Viscous,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
)


def rosa() -> System:
    """A bell hangs on a rod below a cart that is pushed."""
    M, m = parameter("M", 3.0, "kg"), parameter("m", 0.8, "kg")
    d, g = parameter("d", 0.7, "m"), parameter("g", 9.81, "m/s^2")
    x, theta = length("x", -3.0, 3.0, speed=3.0), angle("theta", -1.5, 1.5, speed=6.0)
    rail = move(x, 0, 1.5)
    cart = Body("cart", rail, mass=M, shape=Box(0.4, 0.3, 0.2))
    bell = Body("bell", rail @ rot_y(theta) @ move(0, 0, -d), mass=m, shape=Sphere(0.1))
    return System(
        "rosa",
        bodies=[cart, bell],
        gravity=toward("-z", m * g),
        inputs=[Force("push", on=cart, along=rail.x, limit=15.0)],
        efforts=[Viscous(rate(theta), 0.02)],
        cables=[(rail, bell.frame)],
    )
