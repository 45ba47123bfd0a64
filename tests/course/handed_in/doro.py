"""A cart with a pendulum below it, whose motor follows its command late."""

from kinolab.dynamics import (
    Body,
    Box,
    Control,
    Sphere,
    System,
    Viscous,
    Wrench,
    angle,
    lag,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
)


def late_cart() -> System:
    M, m, l = parameter("M", 3.0, "kg"), parameter("m", 0.5, "kg"), parameter("l", 0.7, "m")
    tau = parameter("tau", 0.15, "s")
    x, theta = length("x", -3.0, 3.0, speed=3.0), angle("theta", speed=6.0)
    rail = move(x, 0, 1.2)
    cart = Body("cart", rail, mass=M, shape=Box(0.4, 0.3, 0.2))
    ball = Body("ball", rail @ rot_y(theta) @ move(0, 0, -l), mass=m, shape=Sphere(0.07))
    command = Control("command", limit=15.0, unit="N")
    push = lag("push", command.symbol, -tau, unit="N")
    return System(
        "late_cart",
        bodies=[cart, ball],
        inputs=[command],
        states=[push],
        efforts=[Wrench(on=cart, force=(push.symbol, 0, 0)), Viscous(rate(theta), 0.02)],
        gravity=toward("-z"),
    )
