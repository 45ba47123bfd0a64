"""A cart that is held by a latch at the end of its rail, if it comes slowly."""

from kinolab.dynamics import (
    Body, Box, Force, Mode, System, Transition, Viscous, closed, length, move, parameter, rate,
)


def latch() -> System:
    """The latch is at 2 m, and takes the cart only below 0.3 m/s."""
    m, c = parameter("m", 2.0, "kg"), parameter("c", 1.0, "N s/m")
    x = length("x", -1.0, 4.0, speed=2.0)
    cart = Body("cart", move(x, 0, 0.2), mass=m, shape=Box(0.4, 0.3, 0.2))
    return System(
        "latch",
        bodies=[cart],
        inputs=[Force("push", on=cart, along=cart.frame.x, limit=3.0)],
        efforts=[Viscous(rate(x), c)],
        modes=[Mode("free"), Mode("latched", constraints=[closed(x - 2, "latched")])],
        transitions=[Transition("latch", "free", "latched", until=2 - x, provided=0.3 - rate(x))],
    )
