"""An arm that a motor at its pivot turns in a vertical plane."""

from kinolab.dynamics import WORLD, Body, Capsule, System, Torque, Viscous, angle, move, parameter, rate, rot_y, toward


def pendulum_arm() -> System:
    """0 hangs; the motor can hold the arm level, and a little more."""
    m, l = parameter("m", 1.0, "kg"), parameter("l", 0.8, "m")
    q = angle("q", -3.5, 3.5, speed=6.0)
    arm = Body(
        "arm", move(0, 0, 1.0) @ rot_y(q) @ move(0, 0, -l / 2), mass=m, inertia=(m * l**2 / 12, m * l**2 / 12, 1e-4),
        shape=Capsule(0.03, l),
    )
    return System(
        "pendulum_arm",
        bodies=[arm],
        inputs=[Torque("motor", on=arm, about=WORLD.y, limit=4.2)],
        efforts=[Viscous(rate(q), 0.05)],
        gravity=toward("-z"),
    )
