"""A road roller: two drums, each in a frame of its own, and a hinge that steers."""

from kinolab.dynamics import (
    Body,
    Box,
    Disk,
    System,
    Torque,
    Viscous,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    toward,
    velocity,
    zero,
)


def road_roller() -> System:
    m, r, a = parameter("m", 900.0, "kg"), parameter("r", 0.5, "m"), parameter("a", 0.9, "m")
    d, b, c = (
        parameter("d", 700.0, "kg"),
        parameter("b", 1.2, "m"),
        parameter("c", 40.0, "N m s/rad"),
    )
    x, y, psi = length("x"), length("y"), angle("psi", speed=2.0)
    delta = angle("delta", -0.6, 0.6, speed=1.0)
    phi_f, phi_r = angle("phi_f", speed=10.0), angle("phi_r", speed=10.0)
    front = move(x, y, r) @ rot_z(psi)
    hinge = front @ move(-a, 0, 0) @ rot_z(delta)
    rear = hinge @ move(-a, 0, 0)
    drum = (d * (3 * r**2 + b**2) / 12, d * r**2 / 2, d * (3 * r**2 + b**2) / 12)
    front_drum = Body(
        "front drum",
        front @ rot_y(phi_f),
        mass=d,
        inertia=drum,
        shape=Disk(r, thickness=b, axis="y"),
        touches_ground=True,
    )
    rear_drum = Body(
        "rear drum",
        rear @ rot_y(phi_r),
        mass=d,
        inertia=drum,
        shape=Disk(r, thickness=b, axis="y"),
        touches_ground=True,
    )
    fore = Body(
        "fore frame", front @ move(-0.2, 0, 0.7), mass=m, inertia=m / 4, shape=Box(1.2, 1.1, 0.3)
    )
    aft = Body(
        "aft frame", rear @ move(0.2, 0, 0.7), mass=m, inertia=m / 4, shape=Box(1.2, 1.1, 0.3)
    )
    F, B = velocity(front), velocity(rear)
    return System(
        "road_roller",
        bodies=[front_drum, rear_drum, fore, aft],
        constraints=[
            zero(F.y, "no sideslip in front"),
            zero(B.y, "no sideslip behind"),
            zero(F.x - r * rate(phi_f), "front drum rolls"),
            zero(B.x - r * rate(phi_r), "rear drum rolls"),
        ],
        gravity=toward("-z"),
        inputs=[
            Torque("drive", on=front_drum, about=front.y, limit=800.0, reacts_on=fore),
            Torque("bend", on=aft, about=hinge.z, limit=2000.0, reacts_on=fore),
        ],
        efforts=[Viscous(rate(phi_f), c), Viscous(rate(phi_r), c), Viscous(rate(delta), 200.0)],
    )
