"""A tractor with a trailer: rear wheels drive, front ones steer, the trailer turns on its hitch."""

from kinolab.dynamics import (
    Body,
    Box,
    Cylinder,
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
    velocity,
    zero,
)


def trailer() -> System:
    M, m = parameter("M", 2500.0, "kg"), parameter("m", 900.0, "kg")
    L, h, b = parameter("L", 2.2, "m"), parameter("h", 0.8, "m"), parameter("b", 3.0, "m")
    R, r = parameter("R", 0.7, "m"), parameter("r", 0.4, "m")
    I_R, I_r = parameter("I_R", 60.0, "kg m^2"), parameter("I_r", 5.0, "kg m^2")
    c = parameter("c", 150.0, "N m s/rad")
    x, y, psi = length("x"), length("y"), angle("psi")  # middle of the rear axle, heading
    delta = angle("delta", -0.7, 0.7, speed=1.0)
    beta = angle("beta", -1.2, 1.2, speed=2.0)  # of the trailer against the tractor
    phi, chi = angle("phi", speed=8.0), angle("chi", speed=14.0)  # rear wheels, trailer's wheels
    rear = move(x, y, R) @ rot_z(psi)
    front = rear @ move(L, 0, r - R) @ rot_z(delta)
    hitch = rear @ move(-h, 0, 0) @ rot_z(beta)
    axle = hitch @ move(-b, 0, r - R)
    hull = (Box(2.6, 0.9, 0.7, at=(0.1, 0, 0.3)), Box(0.8, 0.1, 0.1, at=(-L / 2 - h + 0.4, 0, 0)))
    tractor = Body("tractor", rear @ move(L / 2), mass=M, inertia=2200.0, shape=hull)
    drive_wheels = Body(
        "rear wheels",
        rear @ rot_y(phi),
        mass=240.0,
        inertia=(I_R / 2, I_R, I_R / 2),
        shape=[Disk(R, 0.4, axis="y", at=(0, side, 0)) for side in (0.8, -0.8)],
        touches_ground=True,
    )
    steered = Body(
        "front wheels",
        front,
        mass=60.0,
        inertia=12.0,
        shape=[Disk(r, 0.25, axis="y", at=(0, side, 0)) for side in (0.6, -0.6)],
        touches_ground=True,
    )
    cart = Body(
        "trailer",
        axle @ move(0.3, 0, 0),
        mass=m,
        inertia=1100.0,
        shape=(
            Box(3.0, 1.8, 0.5, at=(0, 0, 0.3)),
            Cylinder(0.05, b - 0.3, "x", (b / 2 - 0.15, 0, 0.3)),
        ),
    )
    trailer_wheels = Body(
        "trailer wheels",
        axle @ rot_y(chi),
        mass=60.0,
        inertia=(I_r / 2, I_r, I_r / 2),
        shape=[Disk(r, 0.25, axis="y", at=(0, side, 0)) for side in (1.0, -1.0)],
        touches_ground=True,
    )
    V, W = velocity(rear), velocity(axle)
    return System(
        "trailer",
        bodies=[tractor, drive_wheels, steered, cart, trailer_wheels],
        constraints=[
            zero(V.y, "no sideslip behind"),
            zero(velocity(front).y, "no sideslip in front"),
            zero(W.y, "no sideslip of the trailer"),
            zero(V.x - R * rate(phi), "rear wheels roll"),
            zero(W.x - r * rate(chi), "trailer wheels roll"),
        ],
        inputs=[
            Torque("drive", on=drive_wheels, about=rear.y, limit=2000.0, reacts_on=tractor),
            Torque("steer", on=steered, about=rear.z, limit=60.0, reacts_on=tractor),
        ],
        efforts=[Viscous(rate(phi), c), Viscous(rate(delta), c)],
    )
