"""A coin that rolls upright."""

from kinolab.dynamics import (
    Body,
    Disk,
    PlaneCurves,
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


def rolling_disk() -> System:
    """A coin that rolls upright on the plane, driven about its axle and steered about the vertical.

    Its rim grips by friction: the forces that keep it from sliding stay within mu m g.

    Source: Bloch, Nonholonomic Mechanics and Control, 2003, section 1.4.
    """
    m, R = parameter("m", 1.0, "kg"), parameter("R", 0.25, "m")
    mu, g = parameter("mu", 0.6), parameter("g", 9.81, "m/s^2")
    x, y = length("x"), length("y")
    psi = angle("psi", speed=4.0)  # heading
    phi = angle("phi", speed=12.0)  # roll
    fork = move(x, y, R) @ rot_z(psi)  # follows the coin, does not spin
    coin = Body(
        "coin",
        fork @ rot_y(phi),
        mass=m,
        inertia=(m * R**2 / 4, m * R**2 / 2, m * R**2 / 4),
        shape=Disk(R, thickness=0.05, axis="y"),
        touches_ground=True,
    )
    V = velocity(fork)
    side, roll = zero(V.y, "no sideslip"), zero(V.x - R * rate(phi), "rolling")
    grip = (mu * m * g) ** 2 - force_of(side) ** 2 - force_of(roll) ** 2  # circle of friction
    return System(
        "rolling_disk",
        bodies=[coin],
        constraints=[side, roll],
        inputs=[
            Torque("drive", on=coin, about=fork.y, limit=1.0),
            Torque("steer", on=coin, about=fork.z, limit=0.5),
        ],
        flat=PlaneCurves(x, y, psi),
        requirements=[require(grip, "the rim grips")],
    )
