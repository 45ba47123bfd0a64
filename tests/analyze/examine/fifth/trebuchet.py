"""A counterweight hangs from the short arm, a stone sits on the long one."""

from kinolab.dynamics import (
    Body,
    Box,
    Sphere,
    System,
    Torque,
    Viscous,
    angle,
    move,
    parameter,
    rate,
    rot_y,
    toward,
)


def trebuchet() -> System:
    M, m, b = parameter("M", 400.0, "kg"), parameter("m", 8.0, "kg"), parameter("b", 60.0, "kg")
    p, q, h = parameter("p", 0.8, "m"), parameter("q", 3.2, "m"), parameter("h", 0.7, "m")
    H, g = parameter("H", 2.8, "m"), parameter("g", 9.81, "m/s^2")
    arm, hang = angle("arm", -2.2, 1.0, speed=8.0), angle("hang", -2.5, 2.5, speed=12.0)
    axle = move(0, 0, H) @ rot_y(arm)
    l = p + q  # noqa: E741
    beam = Body(
        "beam",
        axle @ move((p - q) / 2, 0, 0),
        mass=b,
        inertia=(b * 0.01, b * l**2 / 12, b * l**2 / 12),
        shape=Box(l, 0.15, 0.2),
    )
    box = Body(
        "box",
        axle @ move(p, 0, 0) @ rot_y(hang) @ move(0, 0, -h),
        mass=M,
        inertia=M * 0.06,
        shape=Box(0.6, 0.6, 0.6),
    )
    stone = Body("stone", axle @ move(-q, 0, 0.22), mass=m, inertia=m * 0.006, shape=Sphere(0.12))
    return System(
        "trebuchet",
        bodies=[beam, box, stone],
        gravity=toward("-z", g),
        inputs=[Torque("winch", on=beam, about=axle.y, limit=4000.0)],
        efforts=[Viscous(rate(arm), 5.0), Viscous(rate(hang), 2.0)],
        keep=("H",),
    )
