"""A hovercraft: a fan at the stern pushes it, and a rudder in its stream turns the push aside."""

from sympy import cos, sin

from kinolab.dynamics import (
    Body,
    Box,
    Control,
    System,
    Viscous,
    Wrench,
    angle,
    lag,
    length,
    move,
    parameter,
    rate,
    rot_z,
    velocity,
)


def hovercraft() -> System:
    m, I = parameter("m", 350.0, "kg"), parameter("I", 420.0, "kg m^2")  # noqa: E741
    ahead, aside = parameter("ahead", 40.0, "N s/m"), parameter("aside", 90.0, "N s/m")
    spin, tau = parameter("spin", 150.0, "N m s"), parameter("tau", 0.4, "s")
    x, y = length("x", speed=12.0), length("y", speed=12.0)
    psi = angle("psi", speed=2.0)
    hull_at = move(x, y, 0.4) @ rot_z(psi)
    hull = Body("hull", hull_at, mass=m, inertia=(120.0, 330.0, I), shape=Box(3.4, 1.8, 0.6))
    V = velocity(hull_at)
    gas = Control("gas", limit=(0.0, 600.0), unit="N")
    rudder = Control("rudder", limit=0.5, unit="rad")
    thrust = lag("thrust", gas.symbol, tau, unit="N")
    push = Wrench(
        on=hull,
        force=(thrust.symbol * cos(rudder.symbol), -thrust.symbol * sin(rudder.symbol), 0),
        at=(-1.6, 0, 0.2),
    )
    return System(
        "hovercraft",
        bodies=[hull],
        inputs=[gas, rudder],
        states=[thrust],
        efforts=[push, Viscous(V.x, ahead), Viscous(V.y, aside), Viscous(rate(psi), spin)],
    )
