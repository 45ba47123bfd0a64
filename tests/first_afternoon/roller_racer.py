"""A roller racer: two axles on two bodies, driven by swinging the handlebar alone."""

from kinolab.dynamics import Body, Box, System, Torque, angle, length, move, rot_z, velocity, zero


def roller_racer() -> System:
    """A seat and a handlebar on passive wheels; swinging the bar drives it."""
    x, y = length("x", speed=2.0), length("y", speed=2.0)
    theta, phi = angle("theta", speed=3.0), angle("phi", -1.4, 1.4, speed=6.0)
    seat = move(x, y, 0.1) @ rot_z(theta)
    bar = seat @ move(0.5, 0) @ rot_z(phi) @ move(-0.2, 0)
    rear = Body("seat", seat, mass=2.0, inertia=0.1, shape=Box(0.5, 0.3, 0.1))
    front = Body("bar", bar, mass=0.5, inertia=0.02, shape=Box(0.3, 0.1, 0.1))
    return System(
        "roller_racer",
        bodies=[rear, front],
        constraints=[
            zero(velocity(seat).y, "rear axle"),
            zero(velocity(bar).y, "front axle"),
        ],
        inputs=[Torque("twist", on=front, about=bar.z, limit=2.0, reacts_on=rear)],
    )
