"""A small helicopter with a main rotor, a tail rotor and a disc that tilts."""

from __future__ import annotations

import sympy

from kinolab.dynamics import (
    Body,
    Box,
    Capsule,
    Control,
    Cylinder,
    Disk,
    Shape,
    System,
    Wrench,
    length,
    move,
    orient,
    parameter,
    require,
    rot_x,
    rotation,
    toward,
    velocity,
)

MAST, BOOM, FIN = 0.235, 0.91, 0.08  # [m] of the shapes; the dynamics use h, l_t, h_t
MAIN, TAIL = 0.775, 0.13  # [m] radii of the rotors
WHIRL = 11.0  # [rad/s] in animations, slow enough to be visible; really 167 rad/s
DARK = (0.25, 0.27, 0.31)
AIRFRAME: tuple[Shape, ...] = (
    Capsule(0.13, 0.35, axis="x", at=(0.08, 0, -0.03)),
    Cylinder(0.03, 0.75, axis="x", at=(-0.53, 0, 0.03)),
    Cylinder(0.018, MAST, at=(0, 0, MAST / 2)),
    Box(0.12, 0.012, 0.22, at=(-0.87, 0, 0.06)),  # the fin
    Box(0.09, 0.3, 0.012, at=(-0.68, 0, 0.04)),  # the stabiliser
    *(  # the skids
        part
        for y in (0.14, -0.14)
        for part in (
            Capsule(0.012, 0.5, axis="x", at=(0.05, y, -0.24)),
            Box(0.02, 0.02, 0.12, at=(0.15, 0.8 * y, -0.18)),
            Box(0.02, 0.02, 0.12, at=(-0.05, 0.8 * y, -0.18)),
        )
    ),
)


def helicopter() -> System:
    """A helicopter of 8 kg whose main rotor pushes along a disc that tilts against the mast.

    The inputs are the thrusts of both rotors and how far the main rotor's disc is tilted back (a)
    and to the right (b): flapping follows at once. The disc pulls the body along by the offset of
    its hub and by the stiffness of its blades. The main rotor turns clockwise seen from above, so
    that its drag turns the body to the left and the tail rotor pushes the tail to the left.
    Rotors turn at a governed speed and have no inertia of their own; drag of the fuselage and the
    tail rotor's own torque are left out. Axes: x ahead, y to the left, z up.

    Source: Koo, Sastry, Output tracking control design of a helicopter model based on approximate
    linearization, CDC 1998, with its drag of the rotor; an X-Cell .60 by Gavrilets, Mettler, Feron,
    Nonlinear model for a small-size acrobatic helicopter, AIAA GNC 2001.
    """
    m, g = parameter("m", 8.2, "kg"), parameter("g", 9.81, "m/s^2")
    Ixx, Iyy, Izz = (
        parameter(name, value, "kg m^2")
        for name, value in (("Ixx", 0.18), ("Iyy", 0.34), ("Izz", 0.28))
    )
    x, y, z = length("x", speed=6.0), length("y", speed=6.0), length("z", speed=4.0)
    R = rotation("R", speed=4.0)
    airframe = move(x, y, z) @ orient(R)
    fuselage = Body("fuselage", airframe, mass=m, inertia=(Ixx, Iyy, Izz), shape=AIRFRAME)
    hub = airframe @ move(0, 0, MAST)
    tail = airframe @ move(-BOOM, 0.05, FIN) @ rot_x(-sympy.pi / 2)
    rotors = [
        Body("main rotor", hub, shape=Disk(MAIN, 0.02), color=DARK, whirl=-WHIRL),
        Body("tail rotor", tail, shape=Disk(TAIL, 0.015), color=DARK, whirl=1.5 * WHIRL),
    ]
    V, beta, v_0 = velocity(airframe), parameter("beta", 0.4, "rad"), parameter("v_0", 2.0, "m/s")
    room = (V.x + v_0) * sympy.tan(beta)  # to drift, while hovering by v_0 tan(beta)
    T = Control("thrust", limit=(20.0, 140.0), unit="N")
    T_t = Control("tail", limit=(0.0, 12.0), unit="N")
    a = Control("tilt_back", limit=0.15, unit="rad")
    b = Control("tilt_right", limit=0.15, unit="rad")
    return System(
        "helicopter",
        bodies=[fuselage, *rotors],
        gravity=toward("-z", g),
        inputs=[T, T_t, a, b],
        efforts=[_main_rotor(fuselage, T, a, b), _tail_rotor(fuselage, T_t)],
        requirements=[
            require(room - V.y, "no fast drift to the left"),
            require(room + V.y, "no fast drift to the right"),
        ],
    )


def _main_rotor(fuselage: Body, thrust: Control, back: Control, right: Control) -> Wrench:
    """Thrust along the disc's axis at the hub, the blades' stiffness, and the drag of the blades.

    The drag T^1.5 is that of the induced velocity, so that the thrust must not be negative.
    """
    h, K = parameter("h", MAST, "m"), parameter("K", 54.0, "N m/rad")
    C, D = parameter("C", 0.004452, "m/N^0.5"), parameter("D", 0.6304, "N m")
    T, a, b = thrust.symbol, back.symbol, right.symbol
    axis = (-sympy.sin(a), -sympy.sin(b), sympy.cos(a) * sympy.cos(b))
    drag = C * T ** sympy.Rational(3, 2) + D
    return Wrench(
        on=fuselage,
        force=(T * axis[0], T * axis[1], T * axis[2]),
        torque=(K * b + drag * axis[0], -K * a + drag * axis[1], drag * axis[2]),
        at=(0, 0, h),
    )


def _tail_rotor(fuselage: Body, thrust: Control) -> Wrench:
    """Thrust to the left at the end of the boom."""
    l_t, h_t = parameter("l_t", BOOM, "m"), parameter("h_t", FIN, "m")
    return Wrench(on=fuselage, force=(0, thrust.symbol, 0), at=(-l_t, 0, h_t))
