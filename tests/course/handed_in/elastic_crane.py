"""A trolley that a servo moves, from which a load hangs on a spring."""

from kinolab.dynamics import (
    Body, Box, Cable, Drive, Sphere, Spring, System, Viscous, angle, length, move, parameter, rate, rot_y, toward,
)


def elastic_crane() -> System:
    """The load swings, and bounces on its spring; only the trolley's acceleration is chosen."""
    m, k, l = parameter("m", 1.0, "kg"), parameter("k", 60.0, "N/m"), parameter("l", 0.5, "m")
    x = length("x", -1.0, 3.0, speed=2.0)
    r = length("r", 0.3, 1.2, speed=4.0)  # length of the spring
    theta = angle("theta", -1.0, 1.0, speed=5.0)
    trolley = move(x, 0, 1.6)
    hung = trolley @ rot_y(theta) @ move(0, 0, -r)
    return System(
        "elastic_crane",
        bodies=[
            Body("trolley", trolley, shape=Box(0.3, 0.2, 0.1)),
            Body("load", hung, mass=m, shape=Sphere(0.08)),
        ],
        inputs=[Drive("servo", on=x, limit=4.0)],
        efforts=[
            Spring(between=(trolley, hung), stiffness=k, length=l),
            Viscous(rate(r), 0.8),
            Viscous(rate(theta), 0.05),
        ],
        gravity=toward("-z", 9.81),
        cables=[Cable((trolley, hung), "spring", radius=0.01)],
    )
