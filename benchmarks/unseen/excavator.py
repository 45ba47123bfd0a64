"""The arm of an excavator."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    System,
    Torque,
    Viscous,
    angle,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    toward,
)


def excavator() -> System:
    """An excavator that slews; boom, stick and bucket are lifted by hydraulic moments.

    Cylinders are taken for moments about the joints, valves for viscous friction.

    Source: Koivo, Thoma, Kocaoglan, Andrade-Cetto, Modeling and control of excavator dynamics
    during digging operation, J. Aerospace Engineering 9(1), 1996.
    """
    g = parameter("g", 9.81, "m/s^2")
    m_b, m_s, m_k = parameter("m_b", 300.0), parameter("m_s", 150.0), parameter("m_k", 100.0)
    swing = angle("swing", -2.6, 2.6, speed=1.0)
    boom = angle("boom", -0.5, 1.2, speed=0.8)  # above the horizon
    stick = angle("stick", -2.4, -0.4, speed=1.0)
    curl = angle("curl", -2.0, 0.6, speed=1.5)
    cab = move(0, 0, 1.0) @ rot_z(swing)
    lifted = cab @ move(0.4) @ rot_y(-boom)
    bent = lifted @ move(2.6) @ rot_y(-stick)
    curled = bent @ move(1.4) @ rot_y(-curl)
    base = Body("cab", cab, inertia=(600.0, 600.0, 900.0), shape=Box(1.6, 1.4, 1.2))
    upper = Body("boom", lifted @ move(1.3), mass=m_b, inertia=(5.0, 170.0, 170.0),
                 shape=Box(2.6, 0.25, 0.3))  # fmt: skip
    lower = Body("stick", bent @ move(0.7), mass=m_s, inertia=(2.0, 25.0, 25.0),
                 shape=Box(1.4, 0.2, 0.22))  # fmt: skip
    bucket = Body("bucket", curled @ move(0.35), mass=m_k, inertia=(6.0, 6.0, 6.0),
                  shape=Box(0.7, 0.6, 0.4))  # fmt: skip
    return System(
        "excavator",
        bodies=[base, upper, lower, bucket],
        gravity=toward("-z", g),
        inputs=[
            Torque("slew", on=base, about=WORLD.z, limit=4000.0),
            Torque("lift", on=upper, about=lifted.y, limit=18000.0, reacts_on=base),
            Torque("crowd", on=lower, about=bent.y, limit=6000.0, reacts_on=upper),
            Torque("dump", on=bucket, about=curled.y, limit=1500.0, reacts_on=lower),
        ],
        efforts=[
            Viscous(rate(swing), 2500.0),
            Viscous(rate(boom), 4000.0),
            Viscous(rate(stick), 1200.0),
            Viscous(rate(curl), 200.0),
        ],
    )
