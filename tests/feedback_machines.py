"""Machines that fall over without feedback, and laws that hold them."""

from kinolab.dynamics import (
    Body,
    Box,
    Cylinder,
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

MASSES = {"m": 0.5, "M": 2.0, "l": 1.0, "g": 9.81}  # of the pole's end, of the cart; its length


def cart_pole(*, feedback: bool = True) -> System:
    """A pole that stands on a cart, held up by a regulator that follows a speed."""
    m, M = parameter("m", MASSES["m"], "kg"), parameter("M", MASSES["M"], "kg")
    l, g = parameter("l", MASSES["l"], "m"), parameter("g", MASSES["g"], "m/s^2")  # noqa: E741
    x, theta = length("x", speed=4.0), angle("theta", -0.6, 0.6, speed=4.0)
    joint = move(x, 0, 0.2)
    cart = Body("cart", move(x, 0, 0.15), mass=M, shape=Box(0.5, 0.3, 0.2))
    rod = Cylinder(0.02, l, at=(0, 0, -l / 2))
    pole = Body("pole", joint @ rot_y(theta) @ move(0, 0, l), mass=m, shape=(Sphere(0.08), rod))
    speed = Reference("speed", limit=2.0, unit="m/s")
    law = Regulator(
        [speed],
        tracked={theta: 0.1, rate(theta): 0.5, rate(x): 0.3},
        about={rate(x): speed.symbol},
    )
    return System(
        "cart_pole",
        bodies=[cart, pole],
        gravity=toward("-z", g),
        inputs=[Force("push", on=cart, along=joint.x, limit=20.0)],
        feedback=law if feedback else None,
    )
