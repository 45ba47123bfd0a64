"""The unicycle of dynobench, second order."""

from kinolab.dynamics import (
    Body,
    Control,
    State,
    System,
    angle,
    length,
    move,
    rate,
    rot_z,
    velocity,
    zero,
)
from kinolab.systems._unicycle1 import SIZE


def unicycle2_v0() -> System:
    """A robot whose forward and turning acceleration are given (dynobench).

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/unicycle2_v0.yaml.
    """
    x, y, theta = length("x"), length("y"), angle("theta")
    robot = move(x, y) @ rot_z(theta)
    V = velocity(robot)
    a, aw = Control("a", limit=0.25, unit="m/s^2"), Control("aw", limit=0.25, unit="rad/s^2")
    return System(
        "unicycle2_v0",
        bodies=[Body("robot", robot, shape=SIZE)],
        constraints=[zero(V.y, "no sideslip")],
        states=[
            State("v", a.symbol, velocity=V.x, limits=(-0.5, 0.5), unit="m/s", scale=0.5),
            State(
                "w", aw.symbol, velocity=rate(theta), limits=(-0.5, 0.5), unit="rad/s", scale=0.5
            ),
        ],
        inputs=[a, aw],
    )
