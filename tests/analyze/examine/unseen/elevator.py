"""An elevator with a counterweight."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Cable,
    Coulomb,
    Disk,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    toward,
    zero,
)

TOP = 20.0  # [m] height of the sheave's axle


def elevator() -> System:
    """A sheave with a motor, over which ropes run from the cabin to the counterweight.

    The ropes neither slip nor stretch. Shoes rub along the rails.

    Source: Janovsky, Elevator Mechanical Design, 3rd ed., 1999, chapter 1.
    """
    m_c, m_w = parameter("m_c", 800.0, "kg"), parameter("m_w", 1000.0, "kg")
    m_s, r = parameter("m_s", 120.0, "kg"), parameter("r", 0.5, "m")  # the sheave
    g, rub = parameter("g", 9.81, "m/s^2"), parameter("rub", 100.0, "N")
    z, w = length("z", 0.0, 16.0, speed=2.5), length("w", 0.0, 16.0, speed=2.5)
    phi = angle("phi", speed=5.0)
    axle = move(0, 0, TOP)
    left, right = axle @ move(-r), axle @ move(r)
    cabin = Body("cabin", move(-r, 0, z), mass=m_c, shape=Box(0.9, 1.4, 2.2, at=(0, 0, -1.1)))
    weight = Body(
        "counterweight", move(r, 0, w), mass=m_w, shape=Box(0.2, 1.2, 1.6, at=(0, 0, -0.8))
    )
    I_s = m_s * r**2 / 2
    sheave = Body(
        "sheave",
        axle @ rot_y(phi),
        mass=m_s,
        inertia=(I_s / 2, I_s, I_s / 2),
        shape=Disk(r, 0.15, axis="y"),
    )
    return System(
        "elevator",
        bodies=[cabin, weight, sheave],
        gravity=toward("-z", g),
        constraints=[
            zero(rate(z) - r * rate(phi), "the cabin's rope"),
            zero(rate(w) + r * rate(phi), "the counterweight's rope"),
        ],
        inputs=[Torque("motor", on=sheave, about=WORLD.y, limit=2500.0)],
        efforts=[Coulomb(rate(z), rub), Coulomb(rate(w), rub)],
        cables=[Cable((left, cabin.frame), "rope"), Cable((right, weight.frame), "other rope")],
    )
