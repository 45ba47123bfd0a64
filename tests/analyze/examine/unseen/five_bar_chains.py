"""Two arms that hold one tool over a table (after kinolab.systems, angles relative)."""

from sympy import pi

from kinolab.dynamics import (
    Body,
    Capsule,
    Cylinder,
    Frame,
    System,
    Torque,
    angle,
    closed,
    homogeneous,
    move,
    parameter,
    rot_z,
    toward,
)

LINK = 0.25  # [m]
THICK = 0.011  # [m] radius of a link


def five_bar_chains() -> System:
    a_l, a_r = angle("a_l", -1.5, 1.5, speed=6.0), angle("a_r", -1.5, 1.5, speed=6.0)
    f_l, f_r = angle("f_l", -2.0, 2.0, speed=15.0), angle("f_r", -2.0, 2.0, speed=15.0)
    left = move(-LINK / 2, 0, 0.1) @ rot_z(pi / 2 + a_l)
    right = move(LINK / 2, 0, 0.1) @ rot_z(pi / 2 + a_r)
    left_elbow = left @ move(LINK) @ rot_z(f_l - pi / 6)
    right_elbow = right @ move(LINK) @ rot_z(f_r + pi / 6)
    left_arm = _link("left upper arm", left @ move(LINK / 2), "m_u", 0.3)
    right_arm = _link("right upper arm", right @ move(LINK / 2), "m_u", 0.3)
    left_fore = _link("left forearm", left_elbow @ move(LINK / 2, 0, 0.03), "m_f", 0.15)
    right_fore = _link("right forearm", right_elbow @ move(LINK / 2, 0, 0.06), "m_f", 0.15)
    tip, other = left_elbow @ move(LINK), right_elbow @ move(LINK)
    tool = Body(
        "tool", tip, mass=parameter("m_t", 0.1, "kg"), inertia=3e-4, shape=Cylinder(0.01, 0.18)
    )
    gap = homogeneous(other)[:2, 3] - homogeneous(tip)[:2, 3]
    return System(
        "five_bar_chains",
        bodies=[tool, left_arm, right_arm, left_fore, right_fore],
        gravity=toward("-z", parameter("g", 9.81, "m/s^2")),
        constraints=[closed(gap[0], "they meet along x"), closed(gap[1], "they meet along y")],
        inputs=[
            Torque("left_motor", on=left_arm, about=left.z, limit=0.1),
            Torque("right_motor", on=right_arm, about=right.z, limit=0.1),
        ],
        velocities=[a_l, a_r],
    )


def _link(name: str, place: Frame, mass: str, value: float) -> Body:
    m = parameter(mass, value, "kg")
    across = m * LINK**2 / 12
    rod = Capsule(THICK, LINK, axis="x")
    return Body(name, place, mass=m, inertia=(m * THICK**2 / 2, across, across), shape=rod)
