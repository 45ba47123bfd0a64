"""Machines whose mechanics switch, written as users write them."""

from __future__ import annotations

import sympy

from kinolab.dynamics import (
    Body,
    Force,
    Mode,
    Potential,
    Sphere,
    System,
    Transition,
    angle,
    closed,
    force_of,
    homogeneous,
    length,
    move,
    parameter,
    rot_y,
    toward,
    velocity,
    zero,
)


def ball() -> System:
    """A ball that falls and bounces."""
    z = length("z", -1.0, 10.0)
    return System(
        "ball",
        bodies=[Body("ball", move(0, 0, z), mass=parameter("m", 1.0, "kg"))],
        gravity=toward("-z", 9.81),
        modes=[Mode("flight")],
        transitions=[
            Transition("bounce", "flight", "flight", until=z, restitution=parameter("e", 0.7))
        ],
    )


def walled_pendulum() -> System:
    """A pendulum that swings against a wall."""
    theta = angle("theta")
    wall = parameter("wall", -0.3, "rad")
    return System(
        "walled_pendulum",
        bodies=[Body("bob", rot_y(-theta) @ move(0, 0, -1.0), mass=2.0)],
        gravity=toward("-z", 9.81),
        modes=[Mode("swing")],
        transitions=[Transition("hit", "swing", "swing", until=theta - wall, restitution=0.7)],
    )


def hopper(thrust: bool = False) -> System:
    """A body on a spring above a foot that stands on the ground and leaves it."""
    z, s = length("z", 0.0, 10.0), length("s", -1.0, 1.0)
    L, k = parameter("L", 0.8, "m"), parameter("k", 2000.0, "N/m")
    body, foot = move(0, 0, z), move(0, 0, z - L - s)
    standing = closed(z - L - s, "foot on the ground")
    return System(
        "hopper",
        bodies=[
            Body("body", body, mass=parameter("m", 8.0, "kg"), shape=Sphere(0.15)),
            Body("foot", foot, mass=parameter("m_f", 1.0, "kg"), shape=Sphere(0.05)),
        ],
        efforts=[Potential(k * s**2 / 2)],
        inputs=[Force("thrust", on="body", along="z", limit=100.0)] if thrust else [],
        gravity=toward("-z", 9.81),
        modes=[Mode("stance", constraints=[standing]), Mode("flight")],
        transitions=[
            Transition("lift off", "stance", "flight", until=force_of(standing)),
            Transition("land", "flight", "stance", until=z - L - s),
        ],
    )


def compass_walker() -> System:
    """Two legs that take turns in standing, on a slope that falls to +x."""
    x, z = length("x", -10.0, 100.0), length("z", -100.0, 10.0)
    left, right = angle("left"), angle("right")
    gamma = parameter("gamma", 0.0525, "rad")
    legs = {n: move(x, 0, z) @ rot_y(-a) for n, a in (("left", left), ("right", right))}
    feet = {name: leg @ move(0, 0, -1.0) for name, leg in legs.items()}

    def height(name: str) -> sympy.Expr:
        place = homogeneous(feet[name])[:3, 3]
        return place[0] * sympy.sin(gamma) + place[2] * sympy.cos(gamma)

    def pinned(name: str) -> list[object]:
        V = velocity(feet[name])
        return [zero(V.x, f"{name} foot along"), zero(V.z, f"{name} foot up")]

    stance = {"left": left, "right": right}
    return System(
        "compass_walker",
        bodies=[
            Body("hip", move(x, 0, z), mass=10.0),
            *(Body(f"{n} leg", leg @ move(0, 0, -0.5), mass=5.0) for n, leg in legs.items()),
        ],
        gravity=toward("-z", 9.81),
        modes=[Mode(name, constraints=pinned(name)) for name in stance],
        transitions=[
            Transition(
                f"{other} heel strikes", name, other,
                until=height(other), provided=stance[other] - stance[name] - 0.1,
            )
            for name, other in (("left", "right"), ("right", "left"))
        ],
    )  # fmt: skip
