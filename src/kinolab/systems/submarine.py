"""A small submarine in still water."""

from __future__ import annotations

import math
from numbers import Real

import sympy
from scipy.special import elliprd

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
from kinolab.errors import InputError, Mistake

SLENDERNESS = 5.0  # half length over radius of the hull
HALF_LENGTH = 1.0  # [m] of the shape; the dynamics use the parameter a
RADIUS = HALF_LENGTH / SLENDERNESS  # [m] of the shape
HULL = (
    Capsule(RADIUS, 2 * (HALF_LENGTH - RADIUS), axis="x"),
    Box(0.3, 0.08, 0.2, at=(0.15, 0, 0.25)),  # the sail
    Box(0.15, 0.7, 0.02, at=(-0.85, 0, 0)),  # stern planes
    Box(0.15, 0.02, 0.7, at=(-0.85, 0, 0)),  # rudder
    Cylinder(0.12, 0.08, axis="x", at=(-1.02, 0, 0)),  # the thruster
)


def submarine() -> System:
    """A submarine with a thruster astern and two moments; the water moves with it.

    The hull is a homogeneous, neutrally buoyant ellipsoid of revolution. Its centre of buoyancy
    lies above its centre of mass, so that it rights itself. Water is an unbounded ideal fluid: the
    effect of walls on the added mass is not modelled. Drag is linear and quadratic.

    Source: Leonard, Stability of a bottom-heavy underwater vehicle, Automatica 33(3), 1997; drag as
    in Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, chapter 6.
    """
    rho, a = parameter("rho", 1000.0, "kg/m^3"), parameter("a", HALF_LENGTH, "m")
    g, h = parameter("g", 9.81, "m/s^2"), parameter("h", 0.02, "m")
    b = a / sympy.Float(SLENDERNESS)
    m = sympy.Float(4 / 3 * math.pi) * rho * a * b**2
    about_x, about_y = m * 2 * b**2 / 5, m * (a**2 + b**2) / 5
    k1, k2, k3, k44, k55, k66 = added_mass_coefficients(SLENDERNESS, 1.0, 1.0)
    x, y, z = length("x", speed=2.0), length("y", speed=2.0), length("z", speed=2.0)
    R = rotation("R", speed=1.0)
    hull = move(x, y, z) @ orient(R)
    boat = Body(
        "hull",
        hull,
        mass=m,
        inertia=(about_x, about_y, about_y),
        added_mass=(k1 * m, k2 * m, k3 * m, k44 * about_x, k55 * about_y, k66 * about_y),
        shape=HULL,
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


def added_mass_coefficients(
    a: float, b: float, c: float
) -> tuple[float, float, float, float, float, float]:
    """Return the added-mass coefficients of an ellipsoid, along x, y, z and about x, y, z.

    The first three, k = alpha / (2 - alpha), are fractions of the displaced mass; the others are
    fractions of the displaced fluid's moment of inertia about the same axis, zero about an axis of
    symmetry.

    Args:
        a: Semi-axis along x, positive, in any unit.
        b: Semi-axis along y, in the same unit; it may be equal to others.
        c: Semi-axis along z.

    Raises:
        InputError: If a semi-axis is not a positive, finite number.

    Source: Lamb, Hydrodynamics, 6th ed., 1932, sections 114 and 115; his integrals in Carlson's
    symmetric form R_D, Numerical Algorithms 10, 1995.
    """
    axes = {"a": a, "b": b, "c": c}
    mistakes = [
        Mistake(f"added_mass_coefficients {name}", f"it is {axis!r}.", "Give a positive number.")
        for name, axis in axes.items()
        if not (isinstance(axis, Real) and 0 < axis < math.inf)
    ]
    if mistakes:
        raise InputError(mistakes)
    middle = math.cbrt(a) * math.cbrt(b) * math.cbrt(c)
    x, y, z = ((axis / middle) ** 2 for axis in axes.values())  # only proportions matter
    alpha, beta, gamma = (
        2 / 3 * float(elliprd(*others)) for others in ((y, z, x), (z, x, y), (x, y, z))
    )
    k1, k2, k3 = (fraction / (2 - fraction) for fraction in (alpha, beta, gamma))
    about = (_turning(y, z, beta, gamma), _turning(z, x, gamma, alpha), _turning(x, y, alpha, beta))
    return k1, k2, k3, *about


def _turning(y: float, z: float, beta: float, gamma: float) -> float:
    """Return the coefficient about an axis with squared transverse semi-axes y and z."""
    gap, total = y - z, y + z
    # 1e-6 relative difference of squared semi-axes below which a section is a circle
    if abs(gap) < 1e-6 * total:  # the coefficient is of third order in the gap
        return 0.0
    slope = (gamma - beta) / gap
    return gap**2 * slope / (total * (2 - total * slope))


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
