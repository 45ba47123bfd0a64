"""A cart with a ball on a rod below it."""

from sympy import cos

from kinolab.dynamics import (
    Body, Box, Capsule, Force, Potential, Sphere, System, Viscous, angle, length, move, parameter, rate, rot_y, toward,
)


def swing_cart() -> System:
    """The cart is pushed along a rail; T and V are those of the derivation by hand."""
    M, m = parameter("M", 2.0, "kg"), parameter("m", 0.8, "kg")
    l, g = parameter("l", 0.7, "m"), parameter("g", 9.81, "m/s^2")
    x = length("x", -2.0, 3.0, speed=3.0)
    alpha = angle("alpha", -1.3, 1.3, speed=8.0)
    rail = move(x, 0, 1.2)
    cart = Body("cart", rail, mass=M, shape=Box(0.4, 0.2, 0.1))
    ball = Body(
        "ball", rail @ rot_y(alpha) @ move(0, 0, -l), mass=m,
        shape=(Sphere(0.08), Capsule(0.01, l, at=(0, 0, l / 2))),
    )
    weight = Potential(m * g * (1.2 - l * cos(alpha)))  # the height of the ball
    return System(
        "swing_cart",
        bodies=[cart, ball],
        inputs=[Force("push", on=cart, along=rail.x, limit=15.0)],
        efforts=[weight, Viscous(rate(alpha), 0.02), Viscous(rate(x), 0.5)],
        gravity=toward("-z", g),
    )
