"""A small submarine in still water."""

from __future__ import annotations

import math

import sympy

from kinolab.dynamics import (
    Body,
    BodyVelocity,
    Box,
    Buoyancy,
    Capsule,
    Cylinder,
    Force,
    Parameter,
    System,
    Torque,
    Wrench,
    length,
    move,
    orient,
    parameter,
    rotation,
    toward,
    velocity,
)

SLENDERNESS = 5.0  # half length over radius of the hull
HALF_LENGTH = 1.0  # [m] that is drawn; the parameter a is what displaces water


def submarine() -> System:
    """A submarine with a thruster astern and two moments; the water moves with it.

    The hull is a homogeneous ellipsoid of revolution that weighs what it displaces. Its centre of
    buoyancy lies above its centre of mass, so that it rights itself. Water is an ideal fluid
    without walls: that a corridor changes the added mass is not modelled. Drag is linear and
    quadratic.

    Source: Leonard, Stability of a bottom-heavy underwater vehicle, Automatica 33(3), 1997; drag as
    in Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, chapter 6.
    """
    rho, a = parameter("rho", 1000.0, "kg/m^3"), parameter("a", HALF_LENGTH, "m")
    g, h = parameter("g", 9.81, "m/s^2"), parameter("h", 0.02, "m")
    b = a / sympy.Float(SLENDERNESS)
    m = sympy.Float(4 / 3 * math.pi) * rho * a * b**2
    about_x, about_y = m * 2 * b**2 / 5, m * (a**2 + b**2) / 5
    k1, k2, k55 = added_mass_coefficients(SLENDERNESS)
    x, y, z = length("x", speed=2.0), length("y", speed=2.0), length("z", speed=2.0)
    R = rotation("R", speed=1.0)
    hull = move(x, y, z) @ orient(R)
    boat = Body(
        "hull",
        hull,
        mass=m,
        inertia=(about_x, about_y, about_y),
        added_mass=(k1 * m, k2 * m, k2 * m, 0, k55 * about_y, k55 * about_y),
        shape=_shape(),
    )
    return System(
        "submarine",
        bodies=[boat],
        gravity=toward("-z", g),
        inputs=[
            Force("surge", on=boat, along=hull.x, limit=60.0),
            Torque("pitch", on=boat, about=hull.y, limit=25.0),
            Torque("yaw", on=boat, about=hull.z, limit=25.0),
        ],
        efforts=[Buoyancy(on=boat, lift=m * g, at=(0, 0, h)), _drag(boat, velocity(hull))],
    )


def added_mass_coefficients(slenderness: float) -> tuple[float, float, float]:
    """Return k1, k2 = k3 and k55 = k66 of a prolate ellipsoid of revolution.

    k1 and k2 are fractions of the displaced mass, along and across the axis; k55 is a fraction of
    the displaced fluid's moment of inertia about a cross axis.

    Args:
        slenderness: Length over diameter, more than 1.

    Source: Lamb, Hydrodynamics, 6th ed., 1932, sections 114 and 115.
    """
    e = math.sqrt(1 - slenderness**-2)
    logarithm = math.log((1 + e) / (1 - e))
    alpha = 2 * (1 - e**2) / e**3 * (logarithm / 2 - e)
    beta = 1 / e**2 - (1 - e**2) / (2 * e**3) * logarithm
    turning = e**4 * (beta - alpha) / ((2 - e**2) * (2 * e**2 - (2 - e**2) * (beta - alpha)))
    return alpha / (2 - alpha), beta / (2 - beta), turning


def _drag(boat: Body, V: BodyVelocity) -> Wrench:
    """Return the force and moment of the water, linear and quadratic in each component."""
    d_u, d_uu = parameter("d_u", 30.0, "N s/m"), parameter("d_uu", 15.0, "N s^2/m^2")
    d_v, d_vv = parameter("d_v", 150.0, "N s/m"), parameter("d_vv", 300.0, "N s^2/m^2")
    d_p, d_q = parameter("d_p", 15.0, "N m s"), parameter("d_q", 50.0, "N m s")
    d_qq = parameter("d_qq", 30.0, "N m s^2")

    def against(v: sympy.Expr, linear: Parameter, quadratic: Parameter | int) -> sympy.Expr:
        return -(linear + quadratic * abs(v)) * v

    return Wrench(
        on=boat,
        force=(against(V.x, d_u, d_uu), against(V.y, d_v, d_vv), against(V.z, d_v, d_vv)),
        torque=(against(V.wx, d_p, 0), against(V.wy, d_q, d_qq), against(V.wz, d_q, d_qq)),
    )


def _shape() -> tuple[Capsule | Box | Cylinder, ...]:
    radius = HALF_LENGTH / SLENDERNESS
    return (
        Capsule(radius, 2 * (HALF_LENGTH - radius), axis="x"),
        Box(0.3, 0.08, 0.2, at=(0.15, 0, 0.25)),  # the sail
        Box(0.15, 0.7, 0.02, at=(-0.85, 0, 0)),  # stern planes
        Box(0.15, 0.02, 0.7, at=(-0.85, 0, 0)),  # rudder
        Cylinder(0.12, 0.08, axis="x", at=(-1.02, 0, 0)),  # the thruster
    )
