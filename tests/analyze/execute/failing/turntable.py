"""A turntable with dry friction in its bearing, which may be nothing."""

from kinolab.dynamics import (
    WORLD, Body, Box, Coulomb, System, Torque, Viscous, angle, move, parameter, rate, rot_z,
)


def turntable() -> System:
    """A motor turns it."""
    J, tau = parameter("J", 0.4, "kg m^2"), parameter("tau", 0.0, "N m")
    psi = angle("psi", -3.0, 3.0, speed=3.0)
    table = Body("table", move(0, 0, 0.5) @ rot_z(psi), mass=6.0, inertia=(0.2, 0.2, J), shape=Box(1.0, 0.5, 0.05))
    return System(
        "turntable",
        bodies=[table],
        inputs=[Torque("motor", on=table, about=WORLD.z, limit=1.0)],
        efforts=[Viscous(rate(psi), 0.05), Coulomb(rate(psi), tau, smoothing=0.02)],
    )
