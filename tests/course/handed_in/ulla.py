"""A trolley on a gantry carries a ball on a rod that swings both ways; the page of the project."""

from kinolab.dynamics import (
    Body,
    Box,
    Force,
    Sphere,
    System,
    Viscous,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_x,
    rot_y,
    toward,
)


def carrier() -> System:
    M, m = parameter("M", 4.0, "kg"), parameter("m", 1.0, "kg")
    l, b = parameter("l", 0.8, "m"), parameter("b", 0.05, "N m s")  # noqa: E741
    x, y = length("x", speed=2.0), length("y", speed=2.0)
    alpha, beta = angle("alpha", speed=4.0), angle("beta", speed=4.0)
    carriage = move(x, y, 1.5)
    ball_at = carriage @ rot_y(alpha) @ rot_x(beta) @ move(0, 0, -l)
    trolley = Body("trolley", carriage, mass=M, shape=Box(0.3, 0.3, 0.15))
    ball = Body("ball", ball_at, mass=m, shape=Sphere(0.12))
    return System(
        "carrier",
        bodies=[trolley, ball],
        inputs=[
            Force("push_x", on=trolley, along=carriage.x, limit=10.0),
            Force("push_y", on=trolley, along=carriage.y, limit=10.0),
        ],
        efforts=[Viscous(rate(alpha), b), Viscous(rate(beta), b)],
        gravity=toward("-z"),
    )
