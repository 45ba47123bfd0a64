"""A ball rolls on a beam that a motor tilts; docs/walk.md."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Disk,
    Sphere,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
    zero,
)


def beam_walk() -> System:
    M, L, d = parameter("M", 1.0, "kg"), parameter("L", 1.2, "m"), parameter("d", 0.02, "m")
    m, R = parameter("m", 0.2, "kg"), parameter("R", 0.04, "m")
    H, g = parameter("H", 0.5, "m"), parameter("g", 9.81, "m/s^2")
    alpha = angle("alpha", -0.5, 0.5, speed=4.0)
    r, phi = length("r", -0.55, 0.55, speed=2.0), angle("phi", speed=60.0)
    pivot = move(0, 0, H) @ rot_y(alpha)
    beam = Body("beam", pivot, mass=M, inertia=M * L**2 / 12, shape=Box(L, 0.08, d))
    ball = Body(
        "ball",
        pivot @ move(r, 0, R + d / 2) @ rot_y(phi),
        mass=m,
        inertia=2 * m * R**2 / 5,
        shape=(Sphere(R), Disk(1.02 * R, R / 6, axis="y")),
    )
    return System(
        "ball_beam",
        bodies=[beam, ball],
        constraints=[zero(rate(r) - R * rate(phi), "rolling")],
        inputs=[Torque("motor", on=beam, about=WORLD.y, limit=3.0)],
        gravity=toward("-z", g),
    )
