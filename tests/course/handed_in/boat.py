"""A boat with a propeller and a rudder, seen from above."""

from sympy import Abs, cos, sin

from kinolab.dynamics import (
    Body, Box, Control, Load, System, Viscous, Wrench, angle, length, move, parameter, rot_z, velocity,
)


def boat() -> System:
    """The propeller's jet meets the rudder: without thrust it does not steer. No gravity: it floats."""
    m, J = parameter("m", 20.0, "kg"), parameter("J", 2.5, "kg m^2")
    x, y = length("x", speed=2.5), length("y", speed=2.5)
    psi = angle("psi", speed=1.5)
    hull = move(x, y, 0.1) @ rot_z(psi)
    V = velocity(hull)
    boat = Body("hull", hull, mass=m, inertia=(0.3, 2.4, J), shape=Box(1.2, 0.4, 0.3))
    thrust = Control("thrust", limit=(0.0, 40.0), unit="N")
    rudder = Control("rudder", limit=0.6, unit="rad")
    jet = Wrench(
        on=boat,
        force=(thrust.symbol * cos(rudder.symbol), -thrust.symbol * sin(rudder.symbol), 0),
        at=(-0.6, 0, 0),
    )
    return System(
        "boat",
        bodies=[boat],
        inputs=[thrust, rudder],
        efforts=[
            jet,
            Load(-4.0 * V.x * Abs(V.x), V.x),
            Viscous(V.y, 60.0),
            Viscous(V.wz, 4.0),
        ],
    )
