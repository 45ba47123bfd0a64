"""A plank on a pivot with a spring, along which a weight is driven."""

from kinolab.dynamics import (
    Body, Box, Force, Potential, System, Viscous, angle, length, move, parameter, rate, rot_y, toward,
)


def seesaw() -> System:
    """The motor sits on the plank and pushes the weight along it."""
    M, m = parameter("M", 4.0, "kg"), parameter("m", 0.6, "kg")
    k, d = parameter("k", 60.0, "N m/rad"), parameter("d", 1.0, "N m s/rad")
    theta = angle("theta", -0.4, 0.4, speed=3.0)
    s = length("s", -0.9, 0.9, speed=2.0)
    pivot = move(0, 0, 0.5) @ rot_y(theta)
    plank = Body(
        "plank", pivot, mass=M, shape=Box(2.0, 0.2, 0.05),
        inertia=(1.334, 0.0142, 1.347),  # M (b^2 + h^2) / 12 and so on
    )
    weight = Body("weight", pivot @ move(s, 0, 0.085), mass=m, inertia=0.001, shape=Box(0.12, 0.12, 0.12))
    return System(
        "seesaw",
        bodies=[plank, weight],
        inputs=[Force("motor", on=weight, along=pivot.x, limit=4.0, reacts_on=plank)],
        efforts=[Potential(k * theta**2 / 2), Viscous(rate(theta), d), Viscous(rate(s), 0.5)],
        gravity=toward("-z"),
    )
