"""A forklift that is steered by its rear wheels."""

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
    rot_z,
    velocity,
    zero,
)


def forklift() -> System:
    """A forklift with a pallet: its front axle is driven, its rear wheels are steered.

    The acceleration of the front axle and the rate of the steering angle are imposed; tyres do not
    slip sideways.

    Source: Laumond (ed.), Robot Motion Planning and Control, 1998, chapter 1: a car, driven
    backwards.
    """
    L = parameter("L", 1.6, "m")  # wheelbase
    x, y, psi = length("x"), length("y"), angle("psi")  # middle of the front axle, heading
    delta = angle("delta", -1.0, 1.0, speed=0.8)
    front = move(x, y, 0.6) @ rot_z(psi)
    rear = front @ move(-L) @ rot_z(delta)
    truck = Body("truck", front, shape=(Box(2.2, 1.1, 1.0, at=(-0.9, 0, 0)),))
    pallet = Body("pallet", front @ move(0.9), shape=Box(1.2, 0.8, 0.9))
    V = velocity(front)
    gas = Control("gas", limit=0.8, unit="m/s^2")
    return System(
        "forklift",
        bodies=[truck, pallet],
        constraints=[
            zero(V.y, "no sideslip in front"),
            zero(velocity(rear).y, "no sideslip behind"),
        ],
        inputs=[gas, Rate("steer", on=delta, limit=0.8)],
        states=[
            State("v", gas.symbol, velocity=V.x, limits=(-1.5, 1.5), unit="m/s", scale=1.5),
        ],
    )
