"""A flyer in a vertical plane that two fans carry and push."""

from kinolab.dynamics import WORLD, Body, Force, Sphere, System, Viscous, length, move, parameter, rate, toward


def flyer() -> System:
    """The fan that lifts has a quarter to spare."""
    m, c = parameter("m", 1.0, "kg"), parameter("c", 0.3, "N s/m")
    x, z = length("x", speed=3.0), length("z", speed=3.0)
    body = Body("flyer", move(x, 0, z), mass=m, shape=Sphere(0.15))
    return System(
        "flyer",
        bodies=[body],
        gravity=toward("-z", 9.81),
        inputs=[
            Force("ahead", on=body, along=WORLD.x, limit=3.0),
            Force("lift", on=body, along=WORLD.z, limit=(0.0, 12.3)),
        ],
        efforts=[Viscous(rate(x), c), Viscous(rate(z), c)],
    )
