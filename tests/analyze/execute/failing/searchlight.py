"""A searchlight that a motor turns about the vertical."""

from kinolab.dynamics import (
    WORLD, Body, Cylinder, System, Torque, Viscous, angle, move, parameter, rate, rot_z,
)


def searchlight() -> System:
    """It points along its x axis."""
    J = parameter("J", 0.5, "kg m^2")
    psi = angle("psi", -3.0, 3.0, speed=2.0)
    lamp = Body(
        "lamp", move(0, 0, 1.0) @ rot_z(psi), mass=5.0, inertia=(0.3, 0.3, J), shape=Cylinder(0.2, 0.5, axis="x"),
    )
    return System(
        "searchlight",
        bodies=[lamp],
        inputs=[Torque("motor", on=lamp, about=WORLD.z, limit=0.5)],
        efforts=[Viscous(rate(psi), 0.05)],
    )
