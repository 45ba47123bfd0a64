"""A sledge on skates with a propeller behind and a rudder, in the wind of its own speed."""

from kinolab.dynamics import *


def sledge() -> System:
    m, I, c = parameter("m", 90.0, "kg"), parameter("I", 30.0, "kg m^2"), parameter("c", 1.5, "kg/m")  # noqa: E741
    x, y, psi = length("x"), length("y"), angle("psi", speed=1.5)
    hull = move(x, y, 0.3) @ rot_z(psi)
    V = velocity(hull)
    sledge = Body("sledge", hull, mass=m, inertia=I, shape=Box(1.8, 0.8, 0.4))
    return System(
        "sledge",
        bodies=[sledge],
        gravity=toward("-z"),
        constraints=[zero(V.y, "the skates do not slip sideways")],
        inputs=[
            Force("propeller", on=sledge, along=hull.x, limit=80.0),
            Torque("rudder", on=sledge, about=hull.z, limit=30.0),
        ],
        efforts=[Wrench(on=sledge, force=(-c * V.x**2, 0, 0)), Viscous(rate(psi), 15.0)],
    )
