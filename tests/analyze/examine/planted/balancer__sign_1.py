"""A rod that is balanced on a cart, with its controller."""

from kinolab.dynamics import (
    Body,
    Box,
    Capsule,
    Feedback,
    Force,
    Reference,
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


def balancer() -> System:
    """The controller pushes the cart; a planner chooses the speed that it is asked for."""
    M, m, l = parameter("M", 1.5, "kg"), parameter("m", 0.3, "kg"), parameter("l", 0.8, "m")
    d, g = parameter("d", 0.1, "N s/m"), parameter("g", 9.81, "m/s^2")
    x = length("x", -3.0, 3.0, speed=3.0)
    theta = angle("theta", -0.6, 0.6, speed=4.0)  # of the rod, 0 upright

    joint = move(x, 0, 0.2)
    cart = Body("cart", joint, mass=M, shape=Box(0.4, 0.3, 0.15))
    rod = Body(
        "rod",
        joint @ rot_y(theta) @ move(0, 0, l / 2),
        mass=m,
        inertia=(m * l**2 / 12, m * l**2 / 12, 0.0001),
        shape=Capsule(0.015, l),
    )
    speed = Reference("speed", limit=1.0, unit="m/s")
    law = Feedback(
        [speed],
        {"push": -55 * theta - 13 * rate(theta) - 7 * (rate(x) - speed.symbol)},
    )
    return System(
        "balancer",
        bodies=[cart, rod],
        inputs=[Force("push", on=cart, along=joint.x, limit=20.0)],
        efforts=[Viscous(rate(x), d)],
        gravity=toward("-z", g),
        feedback=law,
    )
