"""An assembly robot with two links in a plane and a spindle."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Cylinder,
    Force,
    System,
    Torque,
    Viscous,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_z,
    toward,
)

HEIGHT = 0.4  # [m] of the links above the table
WIDE, HIGH = 0.12, 0.08  # [m] of the links


def scara() -> System:
    """Two links turn about upright axes; a spindle at their end goes down and turns.

    Source: Spong, Hutchinson, Vidyasagar, Robot Modeling and Control, 2006, section 3.2; masses
    and torques are typical ones.
    """
    m1, l1 = parameter("m1", 6.0, "kg"), parameter("l1", 0.325, "m")
    m2, l2 = parameter("m2", 4.0, "kg"), parameter("l2", 0.275, "m")
    m3, r3 = parameter("m3", 1.5, "kg"), parameter("r3", 0.015, "m")  # the spindle
    g = parameter("g", 9.81, "m/s^2")
    c1, c2 = parameter("c1", 2.0, "N m s/rad"), parameter("c2", 1.0, "N m s/rad")
    c3, c4 = parameter("c3", 20.0, "N s/m"), parameter("c4", 0.02, "N m s/rad")
    q1 = angle("q1", -2.3, 2.3, speed=6.0)
    q2 = angle("q2", -2.5, 2.5, speed=9.0)
    d, q4 = length("d", 0.0, 0.2, speed=1.1), angle("q4", speed=20.0)  # the spindle's way down
    shoulder = move(0, 0, HEIGHT) @ rot_z(q1)
    elbow = shoulder @ move(l1, 0, HIGH) @ rot_z(q2)
    upper = Body(
        "upper arm",
        shoulder @ move(l1 / 2),
        mass=m1,
        inertia=m1 * (l1**2 + WIDE**2) / 12,
        shape=Box(l1, WIDE, HIGH),
    )
    fore = Body(
        "forearm",
        elbow @ move(l2 / 2),
        mass=m2,
        inertia=m2 * (l2**2 + WIDE**2) / 12,
        shape=Box(l2, WIDE, HIGH),
    )
    spindle = Body(
        "spindle",
        elbow @ move(l2, 0, -d) @ rot_z(q4),
        mass=m3,
        inertia=m3 * r3**2 / 2,
        shape=Cylinder(r3, 0.5),
    )
    return System(
        "scara",
        bodies=[upper, fore, spindle],
        gravity=toward("-z", g),
        inputs=[
            Torque("shoulder", on=upper, about=WORLD.z, limit=60.0),
            Torque("elbow", on=fore, about=elbow.z, limit=25.0, reacts_on=upper),
            Force("lift", on=spindle, along=WORLD.z, limit=80.0, reacts_on=fore),
            Torque("wrist", on=spindle, about=elbow.z, limit=2.0, reacts_on=fore),
        ],
        efforts=[
            Viscous(rate(q1), c1),
            Viscous(rate(q2), c2),
            Viscous(rate(d), c3),
            Viscous(rate(q4), c4),
        ],
    )
