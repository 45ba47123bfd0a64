"""A motor boat that rises onto the plane above its hump speed."""

import sympy

from kinolab.dynamics import (
    Body,
    Box,
    Control,
    Mode,
    System,
    Transition,
    Viscous,
    Wrench,
    angle,
    length,
    move,
    parameter,
    rot_z,
    velocity,
)


def motorboat() -> System:
    """A motor boat with an outboard that swivels: it pushes through the water, or planes on it.

    Above 5 m/s it rises and drags less along itself, and holds less aside; below 3.5 m/s it sinks
    back.

    Source: Faltinsen, Hydrodynamics of High-Speed Marine Vehicles, 2005, chapter 9 (the hump of the
    resistance); Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2011, chapter 6
    (linear damping).
    """
    m, J, a = parameter("m", 500.0, "kg"), parameter("J", 700.0, "kg m^2"), 1.8
    x, y = length("x", speed=12.0), length("y", speed=12.0)
    psi = angle("psi", speed=1.5)
    hull = move(x, y, 0.4) @ rot_z(psi)
    V = velocity(hull)
    boat = Body("boat", hull, mass=m, inertia=J, shape=Box(4.2, 1.7, 0.9))
    thrust = Control("thrust", limit=(-600.0, 1500.0), unit="N")
    swivel = Control("swivel", limit=0.5, unit="rad")
    pushed = Wrench(
        on=boat,
        force=(
            thrust.symbol * sympy.cos(swivel.symbol),
            thrust.symbol * sympy.sin(swivel.symbol),
            0,
        ),
        at=(-a, 0, 0),
    )
    return System(
        "motorboat",
        bodies=[boat],
        inputs=[thrust, swivel],
        efforts=[pushed, Viscous(V.wz, 1500.0)],
        modes=[
            Mode("displacing", efforts=[Viscous(V.x, 220.0), Viscous(V.y, 1500.0)]),
            Mode("planing", efforts=[Viscous(V.x, 130.0), Viscous(V.y, 900.0)]),
        ],
        transitions=[
            Transition("rise", "displacing", "planing", until=5.0 - V.x),
            Transition("sink", "planing", "displacing", until=V.x - 3.5),
        ],
    )
