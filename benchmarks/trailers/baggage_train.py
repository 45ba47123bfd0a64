"""A tractor that pulls two baggage carts, each hitched behind the axle of what pulls it."""

from kinolab.dynamics import (
    Body,
    Box,
    Rate,
    System,
    angle,
    length,
    move,
    parameter,
    rot_z,
    velocity,
    zero,
)

FOLDED = 1.0  # [rad] to which a hitch may turn: there a cart's drawbar meets what pulls it


def baggage_train() -> System:
    """A tractor with two carts: its speed and the rate of its steering angle are given.

    Both hitches are behind an axle, so that the train is not flat: no output of the last cart
    determines the rest. Reversing it folds by itself.

    Source: Rouchon, Fliess, Levine, Martin, Flatness and motion planning: the car with n trailers,
    European Control Conference 1993; Altafini, Some properties of the general n-trailer, Int. J.
    Control 74(4), 2001.
    """
    L = parameter("L", 1.4, "m")  # wheelbase of the tractor
    a, b = parameter("a", 0.5, "m"), parameter("b", 0.6, "m")  # hitches behind the axles
    l, d = parameter("l", 1.8, "m"), parameter("d", 1.8, "m")  # noqa: E741  # drawbars to axles
    x, y, psi = length("x"), length("y"), angle("psi")  # of the last cart: its axle and heading
    first = angle("first", -FOLDED, FOLDED, speed=1.5)  # the first cart against the tractor
    second = angle("second", -FOLDED, FOLDED, speed=1.5)  # the second cart against the first
    delta = angle("delta", -0.7, 0.7, speed=1.0)  # steering angle
    last = move(x, y, 0.5) @ rot_z(psi)
    middle = last @ move(d) @ rot_z(-second) @ move(b)
    rear = middle @ move(l) @ rot_z(-first) @ move(a)
    front = rear @ move(L) @ rot_z(delta)
    V = velocity(rear)
    return System(
        "baggage_train",
        bodies=[
            Body("tractor", rear, shape=Box(2.2, 1.2, 0.9, at=(0.7, 0, 0))),
            Body("first cart", middle, shape=Box(2.2, 1.3, 0.9, at=(0.1, 0, 0))),
            Body("second cart", last, shape=Box(2.2, 1.3, 0.9, at=(0.1, 0, 0))),
        ],
        constraints=[
            zero(V.y, "no sideslip behind"),
            zero(velocity(front).y, "no sideslip in front"),
            zero(velocity(middle).y, "no sideslip of the first cart"),
            zero(velocity(last).y, "no sideslip of the second cart"),
        ],
        inputs=[
            Rate("speed", on=V.x, limit=1.5),
            Rate("steer", on=delta, limit=1.0),
        ],
    )
