"""A frame on an overhead table, with a ball that swings below it."""

from kinolab.dynamics import (
    Body, Box, Force, Sphere, System, Viscous, angle, length, move, parameter, rate, rot_x, rot_y, toward,
)


def pusher() -> System:
    """Two forces push the frame, and the ball hangs from it."""
    M, m, l = parameter("M", 3.0, "kg"), parameter("m", 0.5, "kg"), parameter("l", 0.5, "m")
    x, y = length("x", speed=2.0), length("y", speed=2.0)
    a, b = angle("a", -1.2, 1.2, speed=6.0), angle("b", -1.2, 1.2, speed=6.0)
    top = move(x, y, 1.0)
    frame = Body("frame", top, mass=M, shape=Box(0.3, 0.3, 0.1))
    ball = Body("ball", top @ rot_y(a) @ rot_x(b) @ move(0, 0, -l), mass=m, shape=Sphere(0.08))
    return System(
        "pusher",
        bodies=[frame, ball],
        inputs=[
            Force("east", on=frame, along=top.x, limit=10.0),
            Force("north", on=frame, along=top.y, limit=10.0),
        ],
        efforts=[Viscous(rate(a), 0.02), Viscous(rate(b), 0.02), Viscous(rate(x), 0.5), Viscous(rate(y), 0.5)],
        gravity=toward("-z"),
        cables=[(top, ball.frame)],
    )
