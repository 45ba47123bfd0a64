"""A robot on one wheel, with a reaction wheel against falling sideways."""

from __future__ import annotations

import sympy

from kinolab.dynamics import (
    Body,
    Box,
    Cylinder,
    Disk,
    Feedback,
    Reference,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_x,
    rot_y,
    rot_z,
    toward,
    velocity,
    zero,
)
from kinolab.systems._balance import Ahead, Aside
from kinolab.systems._wheels import leaning_wheel

LEAN = 0.6  # [rad] at most, to the side and ahead
WHEEL, HEIGHT, TOP = 0.1, 0.14, 0.26  # [m] of the shapes; the dynamics use R, h and l
HULL = (0.09, 0.07, 0.06)  # [m] edges of the body
SPEED, LEANS = (0.0, 1.5), 0.2  # [m/s], [rad] limits of its references
BODY = (  # a box, a fork down to the axle, two arms up to the reaction wheel
    Box(*HULL),
    *(Box(0.02, 0.006, 0.17, at=(0, side, -0.07)) for side in (-0.022, 0.022)),
    *(Box(0.006, 0.02, 0.12, at=(side, 0, 0.075)) for side in (-0.016, 0.016)),
    Cylinder(0.008, 0.05, axis="y", at=(0, 0, -HEIGHT)),
    Cylinder(0.008, 0.04, axis="x", at=(0, 0, TOP - HEIGHT)),
)


def unicycle() -> System:
    """A unicycle robot: a wheel, an inverted pendulum on its axle, a reaction wheel on that.

    The wheel may lean by theta, to the right if positive; alpha is how far the body is pitched
    ahead in the leaning plane, and gamma turns the reaction wheel about the axis that then points
    ahead. The drive turns wheel and body against each other, the other motor body and reaction
    wheel, so that lean and pitch can be held even at a standstill. There, the heading changes only
    by alternate leaning and pitching; while it rolls, the wheel's angular momentum turns it into
    its lean. Its controller follows a speed and a lean, which decides the turn rate: at 1 m/s a
    lean is held without torque, as weight and turning are in balance.

    Masses, sizes and torques are of the order of such robots, with a wheel heavy enough to steer
    well. The body is a homogeneous cuboid.

    Source: Langius, de Callafon, Dynamic modeling of a moment exchange unicycle robot, ICINCO
    2010; Geist, Fiene, Tashiro, Jia, Trimpe, The Wheelbot, IEEE RA-L 7(4), 2022.
    """
    m_w, R = parameter("m_w", 0.6, "kg"), parameter("R", WHEEL, "m")
    g = parameter("g", 9.81, "m/s^2")
    m_b, h = parameter("m_b", 1.0, "kg"), parameter("h", HEIGHT, "m")  # h above the axle
    m_r, l = parameter("m_r", 0.35, "kg"), parameter("l", TOP, "m")  # noqa: E741  # l above it too
    I_r = parameter("I_r", 1.5e-3, "kg m^2")  # of the reaction wheel about its axis
    x, y = length("x"), length("y")  # where the wheel touches the ground
    psi = angle("psi", speed=4.0)  # heading
    theta = angle("theta", -LEAN, LEAN, speed=4.0)  # lean
    phi = angle("phi", speed=30.0)  # roll of the wheel against the leaning plane
    alpha = angle("alpha", -LEAN, LEAN, speed=6.0)  # pitch
    gamma = angle("gamma", speed=300.0, scale=50.0)  # of the reaction wheel against the body
    track = move(x, y) @ rot_z(psi)
    axle = track @ rot_x(theta) @ move(0, 0, R)  # leans, neither rolls nor pitches
    pitched = axle @ rot_y(alpha)
    wheel = Body(
        "wheel",
        axle @ rot_y(phi),
        mass=m_w,
        inertia=(m_w * R**2 / 4, m_w * R**2 / 2, m_w * R**2 / 4),
        shape=leaning_wheel(R, 0.026, LEAN),
        touches_ground=True,
    )
    body = Body("body", pitched @ move(0, 0, h), mass=m_b, inertia=_cuboid(m_b), shape=BODY)
    flywheel = Body(
        "reaction wheel",
        pitched @ move(0, 0, l) @ rot_x(gamma),
        mass=m_r,
        inertia=(I_r, I_r / 2, I_r / 2),
        shape=Disk(0.075, thickness=0.016, axis="x"),  # [m] radius of the reaction wheel
    )
    first, second = m_w * R + m_b * (R + h) + m_r * (R + l), m_b * h + m_r * l  # moments of mass
    masses, (I_x, I_y, _) = m_w + m_b + m_r, _cuboid(m_b)
    spin = m_w * R**2 / 2  # moment of inertia of the wheel about its axle
    gyroscope = (R * first + spin) * rate(phi) * rate(psi)
    across = m_w * R**2 * sympy.Rational(5, 4) + I_x + m_b * (R + h) ** 2 + m_r * (R + l) ** 2
    aside = Aside(across, g * first * sympy.sin(theta) + gyroscope)
    ahead = Ahead(
        rolling=spin + masses * R**2,
        coupling=second * R,
        tilting=I_y + m_b * h**2 + I_r / 2 + m_r * l**2,
        weight=second * g,
    )
    speed = Reference("speed", limit=SPEED, unit="m/s")
    lean = Reference("lean", limit=LEANS, unit="rad")
    law = {
        "drive": ahead.torque(alpha, rate(phi) - speed.symbol / R),
        "react": aside.torque(theta, lean.symbol),
    }
    V = velocity(track)
    return System(
        "unicycle",
        bodies=[wheel, body, flywheel],
        gravity=toward("-z", g),
        constraints=[zero(V.y, "no sideslip"), zero(V.x - R * rate(phi), "rolling")],
        inputs=[
            Torque("drive", on=wheel, about=axle.y, reacts_on=body, limit=1.0),
            Torque("react", on=flywheel, about=pitched.x, reacts_on=body, limit=1.0),
        ],
        velocities=[psi, theta, phi, alpha, gamma],
        feedback=Feedback([speed, lean], law),
    )


def _cuboid(mass: sympy.Expr) -> tuple[sympy.Expr, sympy.Expr, sympy.Expr]:
    """Return the moments of inertia of the body about its centre."""
    a, b, c = (sympy.Float(edge) ** 2 / 12 for edge in HULL)
    return mass * (b + c), mass * (a + c), mass * (a + b)
