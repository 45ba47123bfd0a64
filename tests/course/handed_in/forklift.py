"""A forklift whose speeds are imposed: it drives, turns and lifts its fork."""

from kinolab.dynamics import Body, Box, Rate, System, angle, length, move, rot_z, velocity, zero


def forklift() -> System:
    """Slow and strong, so that forces do not matter: its state is its configuration."""
    x, y, psi = length("x"), length("y"), angle("psi")
    h = length("h", 0.05, 1.5)  # of the fork above the ground
    frame = move(x, y, 0) @ rot_z(psi)
    V = velocity(frame)
    truck = Body("truck", frame @ move(0, 0, 0.35), shape=Box(0.8, 0.6, 0.6))
    mast = Body("mast", frame @ move(0.42, 0, 0.9), shape=Box(0.04, 0.3, 1.6))
    fork = Body("fork", frame @ move(0.7, 0, h), shape=Box(0.5, 0.3, 0.04))
    return System(
        "forklift",
        bodies=[truck, mast, fork],
        constraints=[zero(V.y, "no sideslip")],
        inputs=[
            Rate("drive", on=V.x, limit=(-0.5, 1.0)),
            Rate("turn", on=psi, limit=0.8),
            Rate("lift", on=h, limit=0.3),
        ],
    )
