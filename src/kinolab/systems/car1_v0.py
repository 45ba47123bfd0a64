"""The car with trailer of dynobench."""

from sympy import atan, cos, pi, sin, tan

from kinolab.dynamics import (
    Body,
    Box,
    Control,
    Rate,
    System,
    angle,
    length,
    move,
    parameter,
    require,
    rot_z,
    velocity,
    zero,
)

HEIGHT = 0.2  # [m] of the shapes; the benchmark is planar


def car1_v0() -> System:
    """A car that pulls a trailer; its speed and its steering angle are given (dynobench).

    The trailer may not fold against the car by more than 45 degrees.

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/car1_v0.yaml.
    """
    L, h = parameter("L", 0.25, "m"), parameter("h", 0.5, "m")  # wheelbase, hitch to trailer axle
    x, y = length("x"), length("y")  # middle of the rear axle, where the hitch is
    theta_0, theta_1 = angle("theta_0"), angle("theta_1")  # headings of car and trailer
    rear = move(x, y) @ rot_z(theta_0)
    trailer = move(x, y) @ rot_z(theta_1) @ move(-h)
    phi = Control("phi", limit=1.047198, unit="rad")  # steering angle
    V, front = velocity(rear), velocity(rear @ move(L))
    folded = 2 * atan(abs(tan((theta_0 - theta_1) / 2)))  # their absolute difference, wrapped
    return System(
        "car1_v0",
        bodies=[
            Body("car", rear, shape=Box(0.5, 0.25, HEIGHT)),
            Body("trailer", trailer, shape=Box(0.3, 0.25, HEIGHT)),
        ],
        constraints=[
            zero(V.y, "no sideslip behind"),
            zero(front.y * cos(phi.symbol) - front.x * sin(phi.symbol), "no sideslip in front"),
            zero(velocity(trailer).y, "no sideslip of the trailer"),
        ],
        inputs=[Rate("v", on=V.x, limit=(-0.1, 0.5)), phi],
        requirements=[require(pi / 4 - folded, "the trailer does not fold")],
    )
