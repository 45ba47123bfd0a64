"""A cart from which two loads hang on rods of different length."""

from kinolab.dynamics import (
    Body, Box, Capsule, Force, Sphere, System, Viscous, angle, length, move, parameter, rate, rot_y, toward,
)


def two_loads() -> System:
    """Only the cart is pushed, and both loads must hang still in the end."""
    M, m1, m2 = parameter("M", 3.0, "kg"), parameter("m1", 0.5, "kg"), parameter("m2", 0.3, "kg")
    l1, l2 = parameter("l1", 0.9, "m"), parameter("l2", 0.4, "m")
    x = length("x", -2.0, 3.0, speed=3.0)
    a1, a2 = angle("a1", -1.2, 1.2, speed=6.0), angle("a2", -1.2, 1.2, speed=8.0)
    rail = move(x, 0, 1.5)
    cart = Body("cart", rail, mass=M, shape=Box(0.6, 0.2, 0.1))
    first = Body(
        "long load", rail @ move(-0.2, 0.15, 0) @ rot_y(a1) @ move(0, 0, -l1), mass=m1,
        shape=(Sphere(0.06), Capsule(0.008, l1, at=(0, 0, l1 / 2))),
    )
    second = Body(
        "short load", rail @ move(0.2, -0.15, 0) @ rot_y(a2) @ move(0, 0, -l2), mass=m2,
        shape=(Sphere(0.05), Capsule(0.008, l2, at=(0, 0, l2 / 2))),
    )
    return System(
        "two_loads",
        bodies=[cart, first, second],
        inputs=[Force("push", on=cart, along=rail.x, limit=20.0)],
        efforts=[Viscous(rate(a1), 0.02), Viscous(rate(a2), 0.01)],
        gravity=toward("-z"),
    )
