"""The first-order unicycle of three dynobench machines, which differ in input limits."""

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
from kinolab.dynamics.language.inputs import Limit

SIZE = Box(0.5, 0.25, 0.2)  # [m]; the benchmark is planar, the height is only that of the shape


def unicycle1(name: str, v: Limit, w: Limit) -> System:
    """Return a robot that rolls without sideslip at a speed v in [m/s] and turns at w in [rad/s].

    Args:
        name: Name of the machine.
        v: Largest speed, or (lower, upper), in [m/s].
        w: Largest turn rate, or (lower, upper), in [rad/s].
    """
    x, y, theta = length("x"), length("y"), angle("theta")
    robot = move(x, y) @ rot_z(theta)
    V = velocity(robot)
    return System(
        name,
        bodies=[Body("robot", robot, shape=SIZE)],
        constraints=[zero(V.y, "no sideslip")],
        inputs=[Rate("v", on=V.x, limit=v), Rate("w", on=theta, limit=w)],
    )
