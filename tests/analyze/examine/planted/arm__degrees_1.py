"""An arm of two links in a vertical plane, with a gripper of two fingers."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Capsule,
    Cylinder,
    Force,
    Spring,
    System,
    Torque,
    Viscous,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_x,
    rot_y,
    toward,
)


def arm() -> System:
    """Motors in the shoulder and in the elbow; a drive opens the fingers against a spring."""
    m1, m2, mf = parameter("m1", 2.0, "kg"), parameter("m2", 1.2, "kg"), parameter("mf", 0.1, "kg")
    l1, l2 = parameter("l1", 0.4, "m"), parameter("l2", 0.35, "m")
    k, g = parameter("k", 300.0, "N/m"), parameter("g", 9.81, "m/s^2")
    q1 = angle("q1", -1.5, 1.5, speed=4.0)  # of the upper arm, 0 upright
    q2 = angle("q2", -2.4, 2.4, speed=6.0)  # of the forearm, 0 straight
    s = length("s", 0.015, 0.05, speed=0.5)  # of each finger from the middle

    shoulder = move(0, 0, 0.6) @ rot_y(q1)
    elbow = shoulder @ move(0, 0, l1) @ rot_y(q2)
    hand = elbow @ move(0, 0, l2) @ rot_x(90)  # its y axis points ahead
    upper = Body(
        "upper arm",
        shoulder @ move(0, 0, l1 / 2),
        mass=m1,
        inertia=(m1 * l1**2 / 12, m1 * l1**2 / 12, 0.002),
        shape=Capsule(0.03, l1),
    )
    fore = Body(
        "forearm",
        elbow @ move(0, 0, l2 / 2),
        mass=m2,
        inertia=(m2 * l2**2 / 12, m2 * l2**2 / 12, 0.001),
        shape=Capsule(0.025, l2),
    )
    left = Body(
        "left finger",
        hand @ move(-s, 0.06, 0),
        mass=mf,
        inertia=(3.3e-5, 5e-6, 3.1e-5),
        shape=Box(0.012, 0.06, 0.02),
    )
    right = Body(
        "right finger",
        hand @ move(s, 0.06, 0),
        mass=mf,
        inertia=(3.3e-5, 5e-6, 3.1e-5),
        shape=Box(0.012, 0.06, 0.02),
    )
    column = Body("column", move(0, 0, 0.29), shape=Cylinder(0.06, 0.58))
    return System(
        "arm",
        bodies=[column, upper, fore, left, right],
        inputs=[
            Torque("shoulder_motor", on=upper, about=WORLD.y, limit=30.0),
            Torque("elbow_motor", on=fore, about=elbow.y, limit=12.0, reacts_on=upper),
            Force("grip", on=right, along=hand.x, limit=20.0, reacts_on=left),
        ],
        efforts=[
            Spring(between=(left.frame, right.frame), stiffness=k, length=0.04),
            Viscous(rate(q1), 0.2),
            Viscous(rate(q2), 0.1),
            Viscous(rate(s), 2.0),
        ],
        gravity=toward("-z", g),
        collisions=[
            ("forearm", "column"),
            ("left finger", "column"),
            ("right finger", "column"),
            ("left finger", "right finger"),
            ("left finger", "upper arm"),
            ("right finger", "upper arm"),
        ],
    )
