"""An arm with three joints on a table top, seen from above."""

from kinolab.dynamics import (
    WORLD, Body, Capsule, System, Torque, Viscous, angle, move, parameter, rate, rot_z, toward,
)


def scara() -> System:
    """It turns in the horizontal plane, so gravity does no work on it."""
    lengths = [parameter(f"l{i}", value, "m") for i, value in ((1, 0.5), (2, 0.4), (3, 0.2))]
    masses = [parameter(f"m{i}", value, "kg") for i, value in ((1, 2.0), (2, 1.2), (3, 0.4))]
    joints = [
        angle("q1", -2.8, 2.8, speed=4.0), angle("q2", -2.4, 2.4, speed=5.0), angle("q3", -2.4, 2.4, speed=8.0),
    ]
    frame, bodies, motors, before = move(0, 0, 0.3), [], [], None
    for i, (l, m, q, limit) in enumerate(zip(lengths, masses, joints, (12.0, 5.0, 1.0)), start=1):
        frame = frame @ rot_z(q)
        link = Body(
            f"link {i}", frame @ move(l / 2), mass=m, inertia=(0.001 * m, m * l**2 / 12, m * l**2 / 12),
            shape=Capsule(0.03, l, axis="x"),
        )
        bodies.append(link)
        if before is None:
            motors.append(Torque("motor1", on=link, about=WORLD.z, limit=limit))
        else:
            motors.append(Torque(f"motor{i}", on=link, about=frame.z, limit=limit, reacts_on=before))
        frame, before = frame @ move(l), link
    return System(
        "scara",
        bodies=bodies,
        inputs=motors,
        efforts=[Viscous(rate(q), 0.05) for q in joints],
        gravity=toward("-z"),
        collisions=[("link 1", "link 3")],
    )
