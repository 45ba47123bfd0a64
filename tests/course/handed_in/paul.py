"""A mower with a trailer for the grass."""

from kinolab.dynamics import (
    Body,
    Box,
    Rate,
    System,
    angle,
    length,
    move,
    rot_z,
    velocity,
    zero,
)


def paul() -> System:
    """A mower whose speed and turn rate are given, with a trailer behind its axle."""
    x, y = length("x"), length("y")
    psi, bend = angle("psi"), angle("bend", -1.2, 1.2)
    mower = move(x, y, 0.3) @ rot_z(psi)
    trailer = mower @ rot_z(bend) @ move(-1.0)
    V, W = velocity(mower), velocity(trailer)
    return System(
        "paul",
        bodies=[
            Body("mower", mower, shape=Box(0.9, 0.5, 0.3, at=(0.2, 0, 0))),
            Body("trailer", trailer, shape=Box(0.7, 0.5, 0.3)),
        ],
        constraints=[zero(V.y, "mower's wheels"), zero(W.y, "trailer's wheels")],
        inputs=[Rate("drive", on=V.x, limit=1.0), Rate("turn", on=psi, limit=1.0)],
    )
