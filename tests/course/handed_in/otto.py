"""A door that a spring and a damper close, and a motor opens."""

from kinolab.dynamics import (
    Body,
    Box,
    Potential,
    System,
    Torque,
    Viscous,
    angle,
    move,
    parameter,
    rate,
    rot_z,
    toward,
)


def otto() -> System:
    """A door with a flap for a cat, which hangs below its middle and swings."""
    from kinolab.dynamics import rot_x

    m, b = parameter("m", 20.0, "kg"), parameter("b", 0.9, "m")
    f, h = parameter("f", 0.6, "kg"), parameter("h", 0.3, "m")
    k, c = parameter("k", 4.0, "N m/rad"), parameter("c", 3.0, "N m s/rad")
    g = parameter("g", 9.81, "m/s^2")
    psi = angle("psi", -0.1, 2.0, speed=3.0)
    flap = angle("flap", -1.5, 1.5, speed=10.0)
    hinge = rot_z(psi)
    door = Body(
        "door",
        hinge @ move(b / 2, 0, 1.1),
        mass=m,
        inertia=(m * (2.0**2) / 12, m * (b**2 + 2.0**2) / 12, m * b**2 / 12),
        shape=Box(b, 0.04, 1.2, at=(0, 0, 0.4)),
    )
    cat = Body(
        "flap",
        hinge @ move(b / 2, 0, 0.9) @ rot_x(flap) @ move(0, 0, -h / 2),
        mass=f,
        inertia=(f * h**2 / 12, f * h**2 / 6, f * h**2 / 12),
        shape=Box(h, 0.02, h),
    )
    return System(
        "otto",
        bodies=[door, cat],
        gravity=toward("-z", g),
        inputs=[Torque("motor", on=door, about=hinge.z, limit=20.0)],
        efforts=[Potential(k * psi**2 / 2), Viscous(rate(psi), c), Viscous(rate(flap), 0.01)],
    )
