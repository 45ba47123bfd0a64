"""The wheeled robots of dynobench: unicycles of first and of second order, a car with a trailer."""

from sympy import atan, cos, pi, sin, tan

from kinolab.dynamics import (
    Body,
    Box,
    Control,
    Rate,
    State,
    System,
    angle,
    length,
    move,
    parameter,
    rate,
    require,
    rot_z,
    velocity,
    zero,
)
from kinolab.dynamics.language.inputs import Limit

SIZE = Box(0.5, 0.25, 0.2)  # [m]; the benchmark is planar, the height is only that of the shape


def unicycle1_v0() -> System:
    """A robot that is moved at a given speed and turn rate (dynobench).

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/unicycle1_v0.yaml.
    """
    return _first_order("unicycle1_v0", v=0.5, w=0.5)


def unicycle1_v1() -> System:
    """A robot that cannot stop: its speed and turn rate are given (dynobench).

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/unicycle1_v1.yaml.
    """
    return _first_order("unicycle1_v1", v=(0.25, 0.5), w=0.5)


def unicycle1_v2() -> System:
    """A robot that cannot stop and turns left better than right (dynobench).

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/unicycle1_v2.yaml.
    """
    return _first_order("unicycle1_v2", v=(0.25, 0.5), w=(-0.25, 0.5))


def _first_order(name: str, v: Limit, w: Limit) -> System:
    """Return a robot that rolls without sideslip at a speed v in [m/s] and turns at w in [rad/s].

    Args:
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
            Body("car", rear, shape=SIZE),
            Body("trailer", trailer, shape=Box(0.3, 0.25, SIZE.z)),
        ],
        constraints=[
            zero(V.y, "no sideslip behind"),
            zero(front.y * cos(phi.symbol) - front.x * sin(phi.symbol), "no sideslip in front"),
            zero(velocity(trailer).y, "no sideslip of the trailer"),
        ],
        inputs=[Rate("v", on=V.x, limit=(-0.1, 0.5)), phi],
        requirements=[require(pi / 4 - folded, "the trailer does not fold")],
    )
