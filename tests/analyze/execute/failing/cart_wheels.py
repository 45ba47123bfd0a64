"""A cart on two wheels whose shapes do not follow the parameter."""

from kinolab.dynamics import (
    Body, Box, Disk, System, Torque, Viscous, angle, length, move, parameter, rate, rot_y, toward, velocity, zero,
)


def cart_wheels() -> System:
    """It rolls along x; the front wheel is driven."""
    M, w, r = parameter("M", 4.0, "kg"), parameter("w", 0.4, "kg"), parameter("r", 0.1, "m")
    x = length("x", speed=2.0)
    front, rear = angle("front", speed=20.0), angle("rear", speed=20.0)
    axles = move(x, 0, r)
    hull = Body("hull", axles @ move(0, 0, 0.15), mass=M, shape=Box(0.6, 0.3, 0.1))
    wheels = []
    for name, at, turn in (("front wheel", 0.25, front), ("rear wheel", -0.25, rear)):
        wheels.append(
            Body(
                name, axles @ move(at, 0, 0) @ rot_y(turn), mass=w,
                inertia=(w * r**2 / 4, w * r**2 / 2, w * r**2 / 4),
                shape=Disk(0.1, thickness=0.05, axis="y"), touches_ground=True,
            )
        )
    V = velocity(axles)
    return System(
        "cart_wheels",
        bodies=[hull, *wheels],
        constraints=[zero(V.x - r * rate(front), "front rolls"), zero(V.x - r * rate(rear), "rear rolls")],
        inputs=[Torque("motor", on=wheels[0], about=axles.y, limit=1.0, reacts_on=hull)],
        efforts=[Viscous(rate(front), 0.02)],
        gravity=toward("-z"),
    )
