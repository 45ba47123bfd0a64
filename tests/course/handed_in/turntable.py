"""A boom that turns about the vertical, with a trolley that is driven along it."""

from kinolab.dynamics import (
    WORLD, Body, Box, Force, System, Torque, Viscous, Wrench, angle, length, move, parameter, rate, rot_z,
)


def turntable() -> System:
    """One motor turns the boom, another one drives the trolley; everything is horizontal."""
    M, m, b = parameter("M", 3.0, "kg"), parameter("m", 1.5, "kg"), parameter("b", 1.6, "m")
    psi = angle("psi", speed=3.0)
    r = length("r", 0.2, 0.75, speed=1.5)
    boom = move(0, 0, 0.8) @ rot_z(psi)
    beam = Body(
        "boom", boom, mass=M, inertia=(0.01, M * b**2 / 12, M * b**2 / 12), shape=Box(b, 0.08, 0.06),
    )
    trolley = Body(
        "trolley", boom @ move(r, 0, -0.11), mass=m, inertia=(0.004, 0.004, 0.005), shape=Box(0.14, 0.14, 0.14),
    )
    centrifugal = Wrench(on=trolley, force=(m * r * rate(psi) ** 2, 0, 0))
    return System(
        "turntable",
        bodies=[beam, trolley],
        inputs=[
            Torque("swing", on=beam, about=WORLD.z, limit=6.0),
            Force("drive", on=trolley, along=boom.x, limit=8.0, reacts_on=beam),
        ],
        efforts=[centrifugal, Viscous(rate(psi), 0.3), Viscous(rate(r), 0.5)],
    )
