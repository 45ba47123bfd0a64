"""A blimp in a vertical plane: it floats, two fans push it."""

from kinolab.dynamics import *


def blimp() -> System:
    m, h = parameter("m", 8.0, "kg"), parameter("h", 0.1, "m")
    x, z = length("x", speed=4.0), length("z", speed=4.0)
    theta = angle("theta", speed=2.0)
    hull = move(x, 0, z) @ rot_y(theta)
    V = velocity(hull)
    bag = Body("bag", hull, mass=m, inertia=4.0, shape=Capsule(0.7, 2.0, axis="x"))
    lift = Buoyancy(on=bag, lift=m, at=(0, 0, h))  # it floats
    return System(
        "blimp",
        bodies=[bag],
        gravity=toward("-z", 9.81),
        inputs=[
            Force("ahead", on=bag, along=hull.x, limit=4.0),
            Force("up", on=bag, along=hull.z, limit=4.0),
        ],
        efforts=[lift, Viscous(V.x, 2.0), Viscous(V.z, 8.0), Viscous(rate(theta), 2.0)],
    )
