"""A cabin and a counterweight on a rope over a sheave that a motor turns."""

from kinolab.dynamics import (
    Body,
    Box,
    Disk,
    System,
    Torque,
    Viscous,
    angle,
    closed,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
    zero,
)


def passenger_lift() -> System:
    m, c, s = parameter("m", 700.0, "kg"), parameter("c", 900.0, "kg"), parameter("s", 60.0, "kg")
    r, g, H = parameter("r", 0.5, "m"), parameter("g", 9.81, "m/s^2"), parameter("H", 20.0, "m")
    z, w = length("z", 1.2, 16.0, speed=2.5), length("w", 1.2, 18.0, speed=2.5)
    phi = angle("phi", speed=6.0)
    top = move(0, 0, H)
    cabin = Body("cabin", move(r, 0, z), mass=m, inertia=m / 2, shape=Box(0.9, 1.4, 2.2))
    counterweight = Body(
        "counterweight", move(-r, 0, w), mass=c, inertia=c / 4, shape=Box(0.08, 1.0, 2.0)
    )
    sheave = Body(
        "sheave",
        top @ rot_y(phi),
        mass=s,
        inertia=(s * r**2 / 4, s * r**2 / 2, s * r**2 / 4),
        shape=Disk(r, thickness=0.1, axis="y"),
    )
    return System(
        "passenger_lift",
        bodies=[cabin, counterweight, sheave],
        constraints=[
            closed(z + w - 18.0, "rope"),
            zero(rate(z) + r * rate(phi), "the rope does not slip"),
        ],
        gravity=toward("-z", g),
        inputs=[Torque("motor", on=sheave, about=top.y, limit=2500.0)],
        efforts=[Viscous(rate(z), 60.0), Viscous(rate(phi), 5.0)],
        cables=[(move(r, 0, z + 1.1), move(r, 0, H)), (move(-r, 0, w + 1.0), move(-r, 0, H))],
    )
