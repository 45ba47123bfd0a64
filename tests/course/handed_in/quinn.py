"""A scooter on one driven wheel and a sliding foot."""

from kinolab.dynamics import (
    Body,
    Box,
    Disk,
    System,
    Torque,
    Viscous,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    velocity,
    zero,
)


def quinn() -> System:
    """A scooter: a hub motor turns its wheel, and another one turns the scooter on its foot."""
    m, r = parameter("m", 6.0, "kg"), parameter("r", 0.1, "m")
    x, y, psi = length("x"), length("y"), angle("psi", speed=2.0)
    phi = angle("phi", speed=15.0)
    axle = move(x, y, r) @ rot_z(psi)
    deck = Body("deck", axle, mass=m, inertia=m * 0.4**2 / 12, shape=Box(0.4, 0.2, 0.04))
    wheel = Body(
        "wheel",
        axle @ rot_y(phi),
        mass=0.5,
        inertia=(0.25 * 0.5 * r**2, 0.5 * 0.5 * r**2, 0.25 * 0.5 * r**2),
        shape=Disk(r, 0.03, axis="y"),
        touches_ground=True,
    )
    V = velocity(axle)
    return System(
        "quinn",
        bodies=[deck, wheel],
        constraints=[zero(V.x, "no sideslip"), zero(V.y - r * rate(phi), "rolling")],
        inputs=[
            Torque("drive", on=wheel, about=axle.y, limit=2.0, reacts_on=deck),
            Torque("turn", on=deck, about=axle.z, limit=1.0),
        ],
        efforts=[Viscous(rate(psi), 0.2)],
    )
