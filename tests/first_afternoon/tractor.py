"""A tractor that steers with its front wheel and pulls two trailers."""

from kinolab.dynamics import (
    Body,
    Box,
    Force,
    Rate,
    System,
    Torque,
    angle,
    length,
    move,
    rot_z,
    velocity,
    zero,
)


def kinematic_tractor() -> System:
    """Speed and steering rate are given."""
    return tractor("kinematic_tractor", with_masses=False)


def dynamic_tractor() -> System:
    """A force drives it, a torque turns its front wheel."""
    return tractor("dynamic_tractor", with_masses=True)


def tractor(name: str, *, with_masses: bool) -> System:
    """Rear axle at (x, y), wheelbase 0.8 m; each trailer's axle is 1.2 m behind its hitch."""
    x, y, psi = length("x"), length("y"), angle("psi")
    delta = angle("delta", -0.7, 0.7, speed=1.0)
    a, b = angle("a", -1.0, 1.0), angle("b", -1.0, 1.0)
    rear = move(x, y, 0.3) @ rot_z(psi)
    front = rear @ move(0.8, 0, 0) @ rot_z(delta)
    first = rear @ rot_z(a) @ move(-1.2, 0, 0)
    second = first @ rot_z(b) @ move(-1.2, 0, 0)
    m = 1.0 if with_masses else 0.0
    bodies = [
        Body(
            "tractor", rear @ move(0.3, 0, 0), mass=80 * m, inertia=10 * m, shape=Box(1, 0.5, 0.4)
        ),
        Body("wheel", front, mass=2 * m, inertia=0.1 * m, shape=Box(0.3, 0.1, 0.3)),
        Body("first", first, mass=40 * m, inertia=5 * m, shape=Box(0.9, 0.5, 0.3)),
        Body("second", second, mass=40 * m, inertia=5 * m, shape=Box(0.9, 0.5, 0.3)),
    ]
    axles = {"rear": rear, "front": front, "first": first, "second": second}
    V = velocity(rear)
    pushed = [
        Force("drive", on=bodies[0], along=rear.x, limit=150.0),
        Torque("steer", on=bodies[1], about=front.z, reacts_on=bodies[0], limit=2.0),
    ]
    given = [Rate("speed", on=V.x, limit=1.0), Rate("steer", on=delta, limit=1.0)]
    return System(
        name,
        bodies=bodies,
        inputs=pushed if with_masses else given,
        constraints=[zero(velocity(axle).y, f"{of} axle") for of, axle in axles.items()],
    )
