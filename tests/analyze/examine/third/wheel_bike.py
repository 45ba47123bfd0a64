"""A bicycle that keeps upright by a reaction wheel."""

from kinolab.dynamics import (
    Body,
    Box,
    Disk,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_x,
    rot_y,
    rot_z,
    toward,
    velocity,
    zero,
)


def wheel_bike() -> System:
    """A bicycle with a steered front wheel, kept upright by a reaction wheel."""
    M, m = parameter("M", 8.0, "kg"), parameter("m", 0.8, "kg")
    r, w = parameter("r", 0.15, "m"), parameter("w", 0.6, "m")  # wheels and wheelbase
    h = parameter("h", 0.3, "m")  # of the frame's centre
    F, b = parameter("F", 2.0, "kg"), parameter("b", 0.12, "m")  # reaction wheel
    g = parameter("g", 9.81, "m/s^2")
    x, y, psi = length("x"), length("y"), angle("psi", speed=2.0)
    lean, delta = angle("lean", -0.4, 0.4, speed=3.0), angle("delta", -0.7, 0.7, speed=3.0)
    phi, chi = angle("phi", speed=30.0), angle("chi", speed=30.0)
    spin = angle("spin", speed=200.0)

    track = move(x, y, 0) @ rot_z(psi)  # below the rear wheel
    upright = track @ rot_x(lean)
    frame = Body(
        "frame",
        upright @ move(w / 2, 0, h),
        mass=M,
        inertia=(M * (0.2**2 + 0.1**2) / 12, M * (w**2 + 0.2**2) / 12, M * (w**2 + 0.1**2) / 12),
        shape=Box(w, 0.1, 0.2),
    )
    moments = (m * r**2 / 4, m * r**2 / 2, m * r**2 / 4)
    axle = upright @ move(0, 0, r)
    rear = Body(
        "rear wheel",
        axle @ rot_y(phi),
        mass=m,
        inertia=moments,
        shape=Disk(r, 0.002, axis="y"),
        touches_ground=True,
    )
    fork = upright @ move(w, 0, r) @ rot_z(delta)
    front = Body(
        "front wheel",
        fork @ rot_y(chi),
        mass=m,
        inertia=moments,
        shape=Disk(r, 0.002, axis="y"),
        touches_ground=True,
    )
    hub = upright @ move(w / 2, 0, h + 0.15)
    flywheel = Body(
        "flywheel",
        hub @ rot_x(spin),
        mass=F,
        inertia=(F * b**2 / 2, F * b**2 / 4, F * b**2 / 4),
        shape=Disk(b, 0.03, axis="x"),
    )
    V, W = velocity(track), velocity(upright @ move(w) @ rot_z(delta))
    return System(
        "wheel_bike",
        bodies=[frame, rear, front, flywheel],
        constraints=[
            zero(V.y, "rear no sideslip"),
            zero(V.x - r * rate(phi), "rear rolling"),
            zero(W.y, "front no sideslip"),
            zero(W.x - r * rate(chi), "front rolling"),
        ],
        inputs=[
            Torque("drive", on=rear, about=upright.y, limit=4.0, reacts_on=frame),
            Torque("steer", on=front, about=fork.z, limit=0.5, reacts_on=frame),
            Torque("balance", on=flywheel, about=upright.x, limit=3.0, reacts_on=frame),
        ],
        gravity=toward("-z", g),
    )
