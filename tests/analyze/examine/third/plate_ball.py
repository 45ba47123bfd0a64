"""A ball rolls on a plate that two motors tilt."""

from sympy import Matrix

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Disk,
    Sphere,
    System,
    Torque,
    angle,
    homogeneous,
    length,
    move,
    orient,
    parameter,
    rate,
    rot_x,
    rot_y,
    rotation,
    toward,
    turn_rate,
    zero,
)


def plate_ball() -> System:
    """A ball rolls on a plate on a universal joint, which two motors tilt."""
    M, L, d = parameter("M", 1.0, "kg"), parameter("L", 0.6, "m"), parameter("d", 0.02, "m")
    m, R = parameter("m", 0.1, "kg"), parameter("R", 0.03, "m")
    H, g = parameter("H", 0.3, "m"), parameter("g", 9.81, "m/s^2")
    alpha = angle("alpha", -0.4, 0.4, speed=3.0)
    beta = angle("beta", -0.4, 0.4, speed=3.0)
    u, v = length("u", -0.27, 0.27, speed=1.0), length("v", -0.27, 0.27, speed=1.0)
    Q = rotation("Q", speed=40.0)

    joint = move(0, 0, H) @ rot_x(alpha)
    top = joint @ rot_y(beta)
    plate = Body(
        "plate",
        top,
        mass=M,
        inertia=(M * L**2 / 12, M * L**2 / 12, M * L**2 / 6),
        shape=Box(L, L, d),
    )
    place = top @ move(u, v, R + d / 2)
    ball = Body(
        "ball",
        place @ orient(Q),
        mass=m,
        inertia=2 * m * R**2 / 5,
        shape=(Sphere(R), Disk(1.02 * R, R / 6, axis="y")),
    )
    spin = homogeneous(orient(Q))[:3, :3] * Matrix(turn_rate(Q))  # in the plate's axes
    return System(
        "plate_ball",
        bodies=[plate, ball],
        constraints=[
            zero(rate(u) - R * spin[1], "rolling along x"),
            zero(rate(v) + R * spin[0], "rolling along y"),
        ],
        inputs=[
            Torque("outer", on=plate, about=WORLD.x, limit=4.0),
            Torque("inner", on=plate, about=top.y, limit=4.0),
        ],
        gravity=toward("-z", g),
    )
