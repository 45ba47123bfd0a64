"""A platform that three propellers hold in the air, in a plane."""

from kinolab.dynamics import (
    Body,
    Box,
    Control,
    Parameter,
    System,
    Wrench,
    angle,
    length,
    move,
    parameter,
    rot_y,
    toward,
)


def tina() -> System:
    """A flying platform: what lifts it is given as an acceleration, and what turns it as well."""
    m, J = parameter("m", 2.5, "kg"), parameter("J", 0.12, "kg m^2")
    g: Parameter = parameter("g", 9.81, "m/s^2")
    x, z = length("x", speed=3.0), length("z", speed=3.0)
    theta = angle("theta", -1.0, 1.0, speed=4.0)
    hull = Body("hull", move(x, 0, z) @ rot_y(theta), mass=m, inertia=J, shape=Box(0.7, 0.3, 0.1))
    lift = Control("lift", limit=(0.0, 40.0), unit="m/s^2")
    turn = Control("turn", limit=2.0, unit="rad/s^2")
    return System(
        "tina",
        bodies=[hull],
        gravity=toward("-z", g),
        inputs=[lift, turn],
        efforts=[Wrench(on=hull, force=(0, 0, lift.symbol), torque=(0, turn.symbol, 0))],
    )
