"""A pole on a cart, with its controller inside."""

from kinolab.dynamics import (
    Body, Box, Capsule, Feedback, Force, Reference, System, Viscous, angle, length, move, parameter, rate, rot_y, toward,
)


def pole_cart() -> System:
    """The law keeps the pole up as long as the pole is as long as it was designed for."""
    M, m, l = parameter("M", 2.0, "kg"), parameter("m", 0.5, "kg"), parameter("l", 1.0, "m")
    x, theta = length("x", speed=4.0), angle("theta", speed=6.0)
    joint = move(x, 0, 0.3)
    cart = Body("cart", joint, mass=M, shape=Box(0.5, 0.3, 0.2))
    pole = Body(
        "pole", joint @ rot_y(theta) @ move(0, 0, l / 2), mass=m, inertia=(m * l**2 / 12, m * l**2 / 12, 1e-4),
        shape=Capsule(0.02, l),
    )
    speed = Reference("speed", limit=1.0, unit="m/s")
    law = Feedback([speed], {"push": 60 * theta + 14 * rate(theta) + 8 * (rate(x) - speed.symbol)})
    return System(
        "pole_cart",
        bodies=[cart, pole],
        inputs=[Force("push", on=cart, along=joint.x, limit=15.0)],
        efforts=[Viscous(rate(x), 0.1)],
        gravity=toward("-z"),
        feedback=law,
    )
