"""A ball hangs from a cart; the first machine of docs/machines.md."""

from kinolab.dynamics import (
    WORLD,
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


def cart_pendulum() -> System:
    M, m = parameter("M", 2.0, "kg"), parameter("m", 0.5, "kg")
    l, g = parameter("l", 1.0, "m"), parameter("g", 9.81, "m/s^2")  # noqa: E741
    x = length("x", -3.0, 3.0, speed=4.0)
    theta = angle("theta", speed=8.0)
    slide = move(x, 0, 1.5)
    cart = Body("cart", slide, mass=M, shape=Box(0.5, 0.3, 0.2))
    rod = slide @ rot_y(-theta) @ move(0, 0, -l)
    ball = Body("ball", rod, mass=m, shape=Sphere(0.08))
    return System(
        "cart_pendulum",
        bodies=[cart, ball],
        gravity=toward("-z", g),
        inputs=[Force("push", on=cart, along=WORLD.x, limit=20.0)],
        efforts=[Viscous(rate(x), 0.1)],
        cables=[(slide, rod)],
    )
