"""A model tractor that steers like a bicycle and pulls a trailer."""

from kinolab.dynamics import (
    Body,
    Box,
    Capsule,
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


def trailer() -> System:
    """The rear wheel drives, the front wheel steers, and the trailer is hitched behind."""
    m1, m2 = parameter("m1", 8.0, "kg"), parameter("m2", 5.0, "kg")
    L, a = parameter("L", 0.5, "m"), parameter("a", 0.2, "m")  # wheelbase, to the centre of mass
    h, d = parameter("h", 0.12, "m"), parameter("d", 0.6, "m")  # axle to hitch, hitch to axle
    R, w = parameter("R", 0.08, "m"), parameter("w", 0.6, "kg")  # of every wheel
    x, y = length("x", speed=2.0), length("y", speed=2.0)  # middle of the rear axle
    psi, theta = angle("psi", speed=3.0), angle("theta", -1.2, 1.2, speed=3.0)
    delta = angle("delta", -0.6, 0.6, speed=2.0)
    phi = angle("phi", speed=25.0)

    rear = move(x, y, R) @ rot_z(psi)
    front = rear @ move(L, 0, 0) @ rot_z(delta)
    cart = rear @ move(-h, 0, 0) @ rot_z(theta) @ move(-d, 0, 0)  # the trailer's axle
    tractor = Body(
        "tractor",
        rear @ move(a, 0, 0.05),
        mass=m1,
        inertia=(0.04, 0.18, 0.2),
        shape=(
            Box(L, 0.2, 0.12, at=(L / 2 - a, 0, 0.1)),
            Box(h, 0.04, 0.03, at=(-h / 2 - a, 0, -0.05)),  # the hitch
        ),
    )
    driven = Body(
        "rear wheel",
        rear @ rot_y(phi),
        mass=w,
        inertia=(w * R**2 / 4, w * R**2 / 2, w * R**2 / 4),
        shape=Disk(R, thickness=0.03, axis="y"),
        touches_ground=True,
    )
    steered = Body(
        "front wheel",
        front,
        mass=w,
        inertia=(w * R**2 / 4, w * R**2 / 2, w * R**2 / 4),
        shape=Disk(R, thickness=0.03, axis="y"),
        touches_ground=True,
    )
    load = Body(
        "trailer",
        cart,
        mass=m2,
        inertia=(5.0e-6, 8.0e-6, 1.1e-5),
        shape=(
            Box(0.4, 0.3, 0.15, at=(0, 0, 0.15)),
            Capsule(0.015, d, axis="x", at=(d / 2, 0, 0)),  # the drawbar
            Disk(R, thickness=0.03, axis="y", at=(0, 0.17, 0)),
            Disk(R, thickness=0.03, axis="y", at=(0, -0.17, 0)),
        ),
        touches_ground=True,
    )
    V = velocity(rear)
    return System(
        "trailer",
        bodies=[tractor, driven, steered, load],
        constraints=[
            zero(V.y, "no sideslip behind"),
            zero(velocity(front).y, "no sideslip in front"),
            zero(velocity(cart).y, "no sideslip of the trailer"),
            zero(V.x - R * rate(phi), "rolling"),
        ],
        inputs=[
            Torque("drive", on=driven, about=rear.y, limit=2.0, reacts_on=tractor),
            Torque("steer", on=steered, about=rear.z, limit=0.5, reacts_on=tractor),
        ],
        efforts=[Viscous(rate(delta), 0.05), Viscous(rate(phi), 0.01)],
        gravity=toward("-z"),
        velocities=[delta, phi],
    )
