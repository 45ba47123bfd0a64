"""A leg that hops up and down along a pole."""

from kinolab.dynamics import (
    Body,
    Box,
    Capsule,
    Mode,
    Potential,
    Pull,
    Sphere,
    System,
    Transition,
    Viscous,
    closed,
    force_of,
    length,
    move,
    parameter,
    rate,
    toward,
)


def hopper() -> System:
    """A trunk above a foot, with a spring, a damper and a muscle between them."""
    m1, m2 = parameter("m1", 6.0, "kg"), parameter("m2", 0.8, "kg")
    k, c = parameter("k", 1500.0, "N/m"), parameter("c", 6.0, "N s/m")
    L, r = parameter("L", 0.7, "m"), parameter("r", 0.05, "m")  # resting leg, the foot's radius
    g = parameter("g", 9.81, "m/s^2")
    z = length("z", 0.35, 2.5, speed=6.0)  # height of the trunk
    s = length("s", -0.35, 0.35, speed=6.0)  # how much longer the leg is than at rest

    hip = move(0, 0, z)
    ankle = hip @ move(0, 0, -(L + s))
    trunk = Body("trunk", hip, mass=m1, shape=Box(0.25, 0.2, 0.2, at=(0, 0, 0.1)))
    foot = Body(
        "foot",
        ankle,
        mass=m2,
        shape=(Sphere(r), Capsule(0.01, 0.4 * L, at=(0, 0, 0.2 * L))),
        touches_ground=True,
    )
    above = z - L - s - r  # of the foot's lowest point
    standing = closed(above, "the foot stands")
    return System(
        "hopper",
        bodies=[trunk, foot],
        inputs=[Pull("muscle", between=(hip, ankle), limit=(-150.0, 150.0))],
        efforts=[Potential(-k * s**2 / 2), Viscous(rate(s), c)],
        gravity=toward("-z", g),
        modes=[Mode("stance", constraints=[standing]), Mode("flight")],
        transitions=[
            Transition("lift off", "stance", "flight", until=force_of(standing)),
            Transition("land", "flight", "stance", until=above),
        ],
    )
