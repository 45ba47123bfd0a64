"""A robot on two driven wheels and a castor, with a camera that looks down a little."""

from kinolab.dynamics import (
    Body,
    Box,
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
    rot_z,
    toward,
    velocity,
    zero,
)


def rover() -> System:
    """Each wheel has its own motor, which sits in the chassis."""
    M, m = parameter("M", 6.0, "kg"), parameter("m", 0.5, "kg")
    R, b = parameter("R", 0.1, "m"), parameter("b", 0.4, "m")  # wheels' radius, track
    c, g = parameter("c", 0.05, "N m s/rad"), parameter("g", 9.81, "m/s^2")
    x, y = length("x", speed=1.5), length("y", speed=1.5)
    psi = angle("psi", speed=4.0)
    left, right = angle("left", speed=15.0), angle("right", speed=15.0)

    axle = move(x, y, R) @ rot_z(psi)
    chassis = Body(
        "chassis",
        axle @ move(-0.05, 0, 0.06),
        mass=M,
        inertia=(0.055, 0.09, 0.125),
        shape=(
            Box(0.4, 0.3, 0.12),
            Sphere(0.03, at=(-0.15, 0, -R - 0.03)),  # the castor
            Box(0.03, 0.03, 0.1, at=(0.15, 0, 0.11)),  # the mast
        ),
        touches_ground=True,
    )
    camera = Body(
        "camera",
        axle @ move(0.1, 0, 0.2) @ rot_y(0.2),
        mass=0.3,
        inertia=(2e-4, 3e-4, 3e-4),
        shape=Box(0.1, 0.06, 0.06),
    )
    wheel_inertia = (m * R**2 / 4, m * R**2 / 2, m * R**2 / 4)
    left_hub, right_hub = axle @ move(0, b / 2, 0), axle @ move(0, -b / 2, 0)
    left_wheel = Body(
        "left wheel",
        left_hub @ rot_y(left),
        mass=m,
        inertia=wheel_inertia,
        shape=Disk(R, thickness=0.04, axis="y"),
        touches_ground=True,
    )
    right_wheel = Body(
        "right wheel",
        right_hub @ rot_y(right),
        mass=m,
        inertia=wheel_inertia,
        shape=Disk(R, thickness=0.04, axis="y"),
        touches_ground=True,
    )
    return System(
        "rover",
        bodies=[chassis, camera, left_wheel, right_wheel],
        constraints=[
            zero(velocity(axle).y, "no sideslip"),
            zero(velocity(left_hub).x + R * rate(left), "left wheel rolls"),
            zero(velocity(right_hub).x - R * rate(right), "right wheel rolls"),
        ],
        inputs=[
            Torque("left_motor", on=left_wheel, about=axle.y, limit=1.0, reacts_on=chassis),
            Torque("right_motor", on=right_wheel, about=axle.y, limit=1.0, reacts_on=chassis),
        ],
        efforts=[Viscous(rate(left), c), Viscous(rate(right), c)],
        gravity=toward("-z", g),
    )
