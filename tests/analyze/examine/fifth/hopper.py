"""A leg that hops; docs/machines.md, the word Mode."""

from kinolab.dynamics import (
    Body,
    Mode,
    Potential,
    Pull,
    System,
    Transition,
    closed,
    force_of,
    length,
    move,
    toward,
)


def hopper() -> System:
    z, s = length("z", 0.3, 3.0, speed=8.0), length("s", -0.5, 0.5, speed=8.0)
    m, m_f, k, L, g = 8.0, 1.0, 2000.0, 0.8, 9.81
    body, foot = move(0, 0, z), move(0, 0, z - L - s)
    standing = closed(z - L - s, "foot on the ground")
    return System(
        "hopper",
        bodies=[Body("body", body, mass=m), Body("foot", foot, mass=m_f)],
        efforts=[Potential(k * s**2 / 2)],
        inputs=[Pull("leg", between=(body, foot), limit=(-200.0, 200.0))],
        gravity=toward("-z", g),
        modes=[Mode("stance", constraints=[standing]), Mode("flight")],
        transitions=[
            Transition("lift off", "stance", "flight", until=force_of(standing)),
            Transition("land", "flight", "stance", until=z - L - s),
        ],
    )
