"""A winch lifts a ram and lets it fall on a pile, which the soil holds by friction."""

from kinolab.dynamics import (
    WORLD,
    Body,
    Coulomb,
    Cylinder,
    Force,
    Mode,
    System,
    Transition,
    Viscous,
    length,
    move,
    parameter,
    rate,
    toward,
)


def pile_driver() -> System:
    m, p = parameter("m", 500.0, "kg"), parameter("p", 300.0, "kg")
    e, F, g = parameter("e", 0.2), parameter("F", 60000.0, "N"), parameter("g", 9.81, "m/s^2")
    z, u = length("z", 0.0, 6.0, speed=12.0), length("u", -3.0, 1.0, speed=8.0)
    ram = Body("ram", move(0, 0, z + 2.5), mass=m, inertia=m / 12, shape=Cylinder(0.25, 1.0))
    pile = Body(
        "pile",
        move(0, 0, u),
        mass=p,
        inertia=p * 4 / 3,
        shape=Cylinder(0.15, 4.0),
        touches_ground=True,
    )
    gap = z - u
    return System(
        "pile_driver",
        bodies=[ram, pile],
        gravity=toward("-z", g),
        inputs=[Force("winch", on=ram, along=WORLD.z, limit=(0.0, 12000.0))],
        efforts=[Coulomb(rate(u), F, smoothing=0.02), Viscous(rate(z), 20.0)],
        modes=[Mode("apart")],
        transitions=[Transition("blow", "apart", "apart", until=gap, restitution=e)],
    )
