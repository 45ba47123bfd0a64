"""My pole."""

from kinolab.dynamics import (
    Body,
    Box,
    Force,
    Reference,
    Regulator,
    Sphere,
    System,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
)


def nora() -> System:
    """A pole on a cart, which a law keeps up."""
    m, M, l, g = (  # noqa: E741
        parameter(n, v, u)
        for n, v, u in [("m", 0.5, "kg"), ("M", 2.0, "kg"), ("l", 1.0, "m"), ("g", 9.81, "m/s^2")]
    )
    x, theta = length("x", speed=4.0), angle("theta", -0.6, 0.6, speed=4.0)
    joint = move(x, 0, 0.2)
    cart = Body("cart", joint, mass=M, shape=Box(0.5, 0.3, 0.2))
    end = Body("end", joint @ rot_y(theta) @ move(0, 0, l), mass=m, shape=Sphere(0.08))
    push = Force("push", on=cart, along=joint.x, limit=20.0)
    speed = Reference("speed", limit=2.0, unit="m/s")
    balance = Regulator(
        [speed],
        tracked={theta: 0.1, rate(theta): 0.5, rate(x): 0.3},
        about={rate(x): speed.symbol},
    )
    return System(
        "nora",
        bodies=[cart, end],
        gravity=toward("-z", g),
        inputs=[push],
        feedback=balance,
    )
