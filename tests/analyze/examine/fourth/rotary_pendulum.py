"""Furuta's pendulum: a motor turns an arm upright, and a rod swings about the arm's length."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Cylinder,
    System,
    Torque,
    Viscous,
    angle,
    move,
    parameter,
    rate,
    rot_x,
    rot_z,
    toward,
)


def rotary_pendulum() -> System:
    ma, la = parameter("ma", 0.25, "kg"), parameter("la", 0.2, "m")
    mp, lp = parameter("mp", 0.12, "kg"), parameter("lp", 0.3, "m")
    ca, cp = parameter("ca", 0.002, "N m s"), parameter("cp", 0.0005, "N m s")
    psi, theta = (
        angle("psi", speed=15.0),
        angle("theta", speed=25.0),
    )  # theta is 0 where the rod hangs
    hub = move(0, 0, 0.5) @ rot_z(psi)
    hinge = hub @ move(la) @ rot_x(theta)
    arm = Body(
        "arm",
        hub @ move(la / 2),
        mass=ma,
        inertia=(ma * 0.01**2 / 2, ma * la**2 / 12, ma * la**2 / 12),
        shape=Cylinder(0.01, la, axis="x"),
    )
    rod = Body(
        "rod",
        hinge @ move(0, 0, -lp / 2),
        mass=mp,
        inertia=(mp * lp**2 / 12, mp * lp**2 / 12, mp * 0.008**2 / 2),
        shape=Cylinder(0.008, lp, axis="z"),
    )
    return System(
        "furuta",
        bodies=[arm, rod],
        inputs=[Torque("motor", on=arm, about=WORLD.z, limit=0.4)],
        efforts=[Viscous(rate(psi), ca), Viscous(rate(theta), cp)],
        gravity=toward("-z"),
    )
