"""A ball that bounces on the ground while a fan pushes it along."""

from kinolab.dynamics import (
    WORLD, Body, Force, Mode, Sphere, System, Transition, length, move, parameter, toward,
)


def bounce() -> System:
    """Each bounce keeps a share e of its speed."""
    m, e = parameter("m", 0.5, "kg"), parameter("e", 0.9, "")
    x, z = length("x", -1.0, 6.0, speed=4.0), length("z", 0.0, 4.0, speed=10.0)
    ball = Body("ball", move(x, 0, z), mass=m, shape=Sphere(0.1), touches_ground=True)
    return System(
        "bounce",
        bodies=[ball],
        inputs=[Force("fan", on=ball, along=WORLD.x, limit=1.5)],
        gravity=toward("-z", 9.81),
        modes=[Mode("flight")],
        transitions=[Transition("bounce", "flight", "flight", until=z - 0.1, restitution=e)],
    )
