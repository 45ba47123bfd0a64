"""A parallel robot: two arms that hold one tool, each turned by a motor on the base."""

from __future__ import annotations

from sympy import Expr, cos, pi, sin

from kinolab.dynamics import (
    Body,
    Capsule,
    Cylinder,
    Frame,
    Parameter,
    System,
    Torque,
    angle,
    closed,
    homogeneous,
    move,
    parameter,
    require,
    rot_z,
    toward,
)

LINK = 0.25  # [m] of the shapes; the dynamics use the parameter l
THICK = 0.011  # [m] radius of a link
LOW, MIDDLE, HIGH = 0.10, 0.13, 0.16  # [m] heights at which links pass each other
BENT, APART = 0.1, 0.2  # least sines required of elbows and between the forearms
ORANGE, STEEL, DARK = (0.85, 0.4, 0.1), (0.6, 0.62, 0.66), (0.2, 0.2, 0.22)
MOTORS = [Cylinder(0.03, 0.085, at=(x, 0, 0.0425)) for x in (-LINK / 2, LINK / 2)]


def five_bar() -> System:
    """Two arms of two links share a tool, which motors at their shoulders move over a table.

    All five bars, the base included, are equally long. The angles are those of the upper arms (a_l,
    a_r) and of the forearms (f_l, f_r) from the home position: the upper arms along y, and the
    forearms the sides of an equilateral triangle. The elbows bend outwards. If the forearms are
    aligned the motors cannot hold the tool, and at a straight elbow they cannot move it on: plans
    must avoid both singularities.

    Source: Campos, Bourbonnais, Bonev, Bigras, Development of a five-bar parallel robot with large
    workspace, ASME IDETC 2010, on robots of equal links; sizes and masses are typical ones.
    """
    l = parameter("l", LINK, "m")  # noqa: E741
    a_l, a_r = angle("a_l", -1.5, 1.5, speed=6.0), angle("a_r", -1.5, 1.5, speed=6.0)
    f_l, f_r = angle("f_l", -2.0, 2.0, speed=15.0), angle("f_r", -2.0, 2.0, speed=15.0)
    left = move(-l / 2, 0, 0) @ rot_z(pi / 2 + a_l)
    right = move(l / 2, 0, 0) @ rot_z(pi / 2 + a_r)
    left_fore = move(-l / 2 - l * sin(a_l), l * cos(a_l)) @ rot_z(pi / 3 + f_l)
    right_fore = move(l / 2 - l * sin(a_r), l * cos(a_r)) @ rot_z(2 * pi / 3 + f_r)
    upper = [_upper("left", left, l), _upper("right", right, l)]
    forearms = [_forearm("left", left_fore, l, MIDDLE), _forearm("right", right_fore, l, HIGH)]
    tip = left_fore @ move(l)
    gap = (homogeneous(right_fore @ move(l)) - homogeneous(tip))[:2, 3]
    base = Body("motors", move(0, 0, 0), shape=MOTORS, touches_ground=True, color=DARK)
    return System(
        "five_bar",
        bodies=[_tool(tip), *upper, *forearms, base],
        gravity=toward("-z", parameter("g", 9.81, "m/s^2")),
        constraints=[
            closed(gap[0], "the forearms meet along x"),
            closed(gap[1], "the forearms meet along y"),
        ],
        inputs=[
            Torque("left_motor", on=upper[0], about=left.z, limit=0.1),
            Torque("right_motor", on=upper[1], about=right.z, limit=0.1),
        ],
        requirements=[
            require(sin(pi / 6 + a_l - f_l) - BENT, "the left elbow bends outwards"),
            require(sin(pi / 6 + f_r - a_r) - BENT, "the right elbow bends outwards"),
            require(sin(pi / 3 + f_r - f_l) - APART, "the forearms do not line up"),
        ],
        collisions=[("tool", "left upper arm"), ("tool", "right upper arm")],
        velocities=[a_l, a_r],
    )


def _upper(side: str, shoulder: Frame, reach: Parameter) -> Body:
    """Return an upper arm, a slender rod along x from its shoulder."""
    m = parameter("m_u", 0.3, "kg")
    rod = Capsule(THICK, LINK, axis="x")
    place = shoulder @ move(reach / 2, 0, LOW)
    return Body(
        f"{side} upper arm", place, mass=m, inertia=_slender(m, reach), shape=rod, color=ORANGE
    )


def _forearm(side: str, elbow: Frame, reach: Parameter, height: float) -> Body:
    """Return a forearm at a height in [m], with the pin of its elbow."""
    m = parameter("m_f", 0.15, "kg")
    depth = height - LOW + 2 * THICK
    pin = Cylinder(1.4 * THICK, depth, at=(-LINK / 2, 0, (LOW - height) / 2))
    shape = (Capsule(THICK, LINK, axis="x"), pin)
    place = elbow @ move(reach / 2, 0, height)
    return Body(
        f"{side} forearm", place, mass=m, inertia=_slender(m, reach), shape=shape, color=STEEL
    )


def _slender(m: Parameter, reach: Parameter) -> tuple[Expr, Expr, Expr]:
    """Return the moments of inertia of a rod along x."""
    across = m * reach**2 / 12
    return m * THICK**2 / 2, across, across


def _tool(tip: Frame) -> Body:
    """Return the tool: a pin through both forearms that ends just above the table."""
    m = parameter("m_t", 0.1, "kg")
    inertia = (m * 0.18**2 / 12, m * 0.18**2 / 12, m * 0.01**2 / 2)
    shape = Cylinder(0.01, 0.18)
    return Body("tool", tip @ move(0, 0, 0.10), mass=m, inertia=inertia, shape=shape, color=DARK)
