"""A Furuta pendulum: an arm turns, a rod swings at its end, a flywheel on that."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Cylinder,
    Disk,
    Potential,
    System,
    Torque,
    Viscous,
    angle,
    move,
    parameter,
    rate,
    rot_x,
    rot_z,
    toward,
)


def flywheel_furuta() -> System:
    m_a, m_p, m_f = (
        parameter("m_a", 0.3, "kg"),
        parameter("m_p", 0.12, "kg"),
        parameter("m_f", 0.1, "kg"),
    )
    r, l = parameter("r", 0.25, "m"), parameter("l", 0.3, "m")  # noqa: E741  # arm, rod
    R, g = parameter("R", 0.04, "m"), parameter("g", 9.81, "m/s^2")  # R of the flywheel
    b_a, b_p = parameter("b_a", 0.002, "N m s/rad"), parameter("b_p", 0.0005, "N m s/rad")
    k = parameter("k", 0.05, "N m/rad")  # of the cable that winds up about the post
    alpha, theta = (
        angle("alpha", -6.0, 6.0, speed=15.0),
        angle("theta", speed=25.0),
    )  # theta = 0 hangs
    phi = angle("phi", speed=300.0)  # flywheel
    post = move(0, 0, 0.5)
    arm_frame = post @ rot_z(alpha)
    hinge = arm_frame @ move(r, 0, 0) @ rot_x(theta)
    post_body = Body("post", move(0, 0, 0.245), shape=Cylinder(0.03, 0.49), touches_ground=True)
    arm = Body(
        "arm",
        arm_frame @ move(r / 2, 0, 0),
        mass=m_a,
        inertia=(0, m_a * r**2 / 12, m_a * r**2 / 12),
        shape=Box(r, 0.02, 0.02),
    )
    rod = Body(
        "rod",
        hinge @ move(0, 0, -l / 2),
        mass=m_p,
        inertia=(m_p * l**2 / 12, m_p * l**2 / 12, 0),
        shape=Box(0.01, 0.01, l),
    )
    flywheel = Body(
        "flywheel",
        hinge @ move(0.02, 0, -l) @ rot_x(phi),
        mass=m_f,
        inertia=(m_f * R**2 / 2, m_f * R**2 / 4, m_f * R**2 / 4),
        shape=Disk(R, 0.015, axis="x"),
    )
    efforts = [Viscous(rate(alpha), b_a), Viscous(rate(theta), b_p), Potential(k * alpha**2 / 2)]
    return System(
        "flywheel_furuta",
        bodies=[post_body, arm, rod, flywheel],
        gravity=toward("-z", g),
        inputs=[
            Torque("motor", on=arm, about=WORLD.z, limit=0.5),
            Torque("spin", on=flywheel, about=hinge.x, limit=0.1, reacts_on=rod),
        ],
        efforts=efforts,
    )
