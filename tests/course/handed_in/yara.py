"""The README's coin, handed in as it stands there."""

from kinolab.dynamics import (
    Body,
    Disk,
    System,
    Torque,
    angle,
    force_of,
    length,
    move,
    parameter,
    rate,
    require,
    rot_y,
    rot_z,
    velocity,
    zero,
)


def coin() -> System:
    m, R = parameter("m", 1.0, "kg"), parameter("R", 0.25, "m")
    mu, g = parameter("mu", 0.6), parameter("g", 9.81, "m/s^2")
    x, y = length("x"), length("y")
    psi, phi = angle("psi", speed=4.0), angle("phi", speed=12.0)
    fork = move(x, y, R) @ rot_z(psi)
    body = Body(
        "coin",
        fork @ rot_y(phi),
        mass=m,
        touches_ground=True,
        inertia=(m * R**2 / 4, m * R**2 / 2, m * R**2 / 4),
        shape=Disk(R, thickness=0.05, axis="y"),
    )
    V = velocity(fork)
    side, roll = zero(V.y, "no sideslip"), zero(V.x - R * rate(phi), "rolling")
    grip = (mu * m * g) ** 2 - force_of(side) ** 2 - force_of(roll) ** 2
    return System(
        "coin",
        bodies=[body],
        constraints=[side, roll],
        inputs=[
            Torque("drive", on=body, about=fork.y, limit=1.0),
            Torque("steer", on=body, about=fork.z, limit=0.5),
        ],
        requirements=[require(grip, "the rim grips")],
    )
