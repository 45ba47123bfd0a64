"""My press."""

from sympy import cos, sin

from kinolab.dynamics import (
    Body,
    Box,
    Capsule,
    Control,
    Disk,
    Spring,
    State,
    System,
    Viscous,
    Wrench,
    angle,
    closed,
    length,
    move,
    parameter,
    rate,
    rot_y,
    state,
    toward,
)


def lena() -> System:
    """A crank, a rod and a ram, which a spring carries; the motor has a coil."""
    H, g = parameter("H", 0.6, "m"), parameter("g", 9.81, "m/s^2")
    r, l = parameter("r", 0.05, "m"), parameter("l", 0.25, "m")  # noqa: E741
    D, m, M = parameter("D", 2.0, "kg"), parameter("m", 0.4, "kg"), parameter("M", 3.0, "kg")
    k_s, l_0 = parameter("k_s", 800.0, "N/m"), parameter("l_0", 0.35, "m")
    c = parameter("c", 5.0, "N s/m")
    K, R, L = parameter("K", 0.3, "N m/A"), parameter("R", 1.0, "ohm"), parameter("L", 0.02, "H")
    alpha, beta = angle("alpha", speed=20.0), angle("beta", -0.5, 0.5, speed=20.0)
    s = length("s", -0.12, 0.01, speed=2.0)  # of the ram, 0 at the top

    shaft = move(0, 0, H)
    turned = shaft @ rot_y(alpha)
    crank = Body(
        "crank",
        turned,
        mass=D,
        inertia=(D * 0.1**2 / 4, D * 0.1**2 / 2, D * 0.1**2 / 4),
        shape=Disk(0.1, 0.02, axis="y"),
    )
    pin = shaft @ move(r * sin(alpha), 0, r * cos(alpha))
    rod = Body(
        "rod",
        pin @ rot_y(beta) @ move(0, 0, -l / 2),
        mass=m,
        inertia=(m * l**2 / 12, m * l**2 / 12, m * 0.015**2 / 2),
        shape=Capsule(0.015, l, axis="z"),
    )
    ram = Body("ram", shaft @ move(0, 0, r - l + s), mass=M, shape=Box(0.08, 0.08, 0.1))
    hanger = move(0, 0.1, H + 0.2)
    voltage, i = Control("voltage", limit=24.0, unit="V"), state("i")
    coil = State("i", (voltage.symbol - R * i - K * rate(alpha)) / L, unit="A", scale=10.0)
    return System(
        "lena",
        bodies=[crank, rod, ram],
        constraints=[
            closed(r * sin(alpha) - l * sin(beta), "the rod ends on the axis"),
            closed(r * cos(alpha) - l * cos(beta) - r + l - s, "the rod ends at the ram"),
        ],
        inputs=[voltage],
        states=[coil],
        efforts=[
            Wrench(on=crank, torque=(0, K * i, 0)),
            Spring(between=(hanger, ram.frame), stiffness=k_s, length=l_0),
            Viscous(rate(s), c),
        ],
        gravity=toward("-z", g),
    )
