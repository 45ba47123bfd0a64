"""A robot that balances on a ball, in a vertical plane: a motor turns the ball against the body."""

from kinolab.dynamics import (
    WORLD,
    Body,
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


def ballbot() -> System:
    m, R = parameter("m", 3.0, "kg"), parameter("R", 0.11, "m")
    M, h = parameter("M", 12.0, "kg"), parameter("h", 0.5, "m")
    J, c = parameter("J", 0.55, "kg m^2"), parameter("c", 0.02, "N m s")
    x = length("x", -3.0, 3.0, speed=2.0)
    phi, theta = angle("phi", speed=20.0), angle("theta", -0.6, 0.6, speed=3.0)
    centre = move(x, 0, R)
    ball = Body(
        "ball",
        centre @ rot_y(phi),
        mass=m,
        inertia=2 * m * R**2 / 5,
        shape=(Sphere(R), Disk(1.01 * R, R / 6, axis="y")),
        touches_ground=True,
    )
    body = Body(
        "body",
        centre @ rot_y(theta) @ move(0, 0, h),
        mass=M,
        inertia=(J, J, 0.09),
        shape=Cylinder(0.12, 0.7),
    )
    return System(
        "ballbot",
        bodies=[ball, body],
        constraints=[zero(velocity(centre).x - R * rate(phi), "rolling")],
        inputs=[Torque("motor", on=ball, about=WORLD.y, limit=8.0, reacts_on=body)],
        efforts=[Viscous(rate(phi) - rate(theta), c)],
        gravity=toward("-z"),
    )
