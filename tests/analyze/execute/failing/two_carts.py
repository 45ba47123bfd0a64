"""Two carts on one rail."""

from kinolab.dynamics import Body, Box, Force, System, Viscous, length, move, parameter, rate


def two_carts() -> System:
    """Each is pushed by itself; they may not touch."""
    m1, m2 = parameter("m1", 1.0, "kg"), parameter("m2", 1.0, "kg")
    c1, c2 = parameter("c1", 0.5, "N s/m"), parameter("c2", 0.5, "N s/m")
    x1, x2 = length("x1", -1.0, 5.0, speed=2.0), length("x2", -1.0, 5.0, speed=2.0)
    left = Body("left cart", move(x1, 0, 0.2), mass=m1, shape=Box(0.4, 0.3, 0.2))
    right = Body("right cart", move(x2, 0, 0.2), mass=m2, shape=Box(0.4, 0.3, 0.2))
    return System(
        "two_carts",
        bodies=[left, right],
        inputs=[
            Force("push_left", on=left, along=left.frame.x, limit=2.0),
            Force("push_right", on=right, along=right.frame.x, limit=2.0),
        ],
        efforts=[Viscous(rate(x1), c1), Viscous(rate(x2), c2)],
        collisions=[("left cart", "right cart")],
    )
