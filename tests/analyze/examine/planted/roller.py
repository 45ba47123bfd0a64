"""Two wheels on one axle, from which a heavy pendulum hangs."""

from kinolab.dynamics import (
    Body,
    Capsule,
    Cylinder,
    Disk,
    Sphere,
    System,
    Torque,
    Viscous,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
    velocity,
    zero,
)


def roller() -> System:
    """A motor between axle and pendulum lifts the pendulum, and its weight makes the wheels roll."""
    M, m = parameter("M", 2.0, "kg"), parameter("m", 1.5, "kg")
    R, l = parameter("R", 0.25, "m"), parameter("l", 0.15, "m")
    w, g = parameter("w", 0.3, "m"), parameter("g", 9.81, "m/s^2")  # w: between the wheels
    x = length("x", speed=3.0)
    phi, theta = angle("phi", speed=12.0), angle("theta", speed=10.0)

    axle = move(x, 0, R)
    wheels = Body(
        "wheels",
        axle @ rot_y(phi),
        mass=M,
        inertia=(M * R**2 / 2 + M * w**2 / 4, M * R**2, M * R**2 / 2 + M * w**2 / 4),  # two rings
        shape=(
            Disk(R, thickness=0.02, axis="y", at=(0, w / 2, 0)),
            Disk(R, thickness=0.02, axis="y", at=(0, -w / 2, 0)),
            Cylinder(0.012, w, axis="y"),  # the axle
        ),
        touches_ground=True,
    )
    bob = Body(
        "bob",
        axle @ rot_y(theta) @ move(0, 0, -l),
        mass=m,
        inertia=2 * m * 0.05**2 / 5,
        shape=(Sphere(0.05), Capsule(0.01, l, axis="z", at=(0, 0, l / 2))),
    )
    return System(
        "roller",
        bodies=[wheels, bob],
        constraints=[zero(velocity(axle).x - R * rate(phi), "rolling")],
        inputs=[Torque("motor", on=bob, about=axle.y, limit=2.0, reacts_on=wheels)],
        efforts=[Viscous(rate(theta) - rate(phi), 0.02)],  # in the bearing
        gravity=toward("-z", g),
    )
