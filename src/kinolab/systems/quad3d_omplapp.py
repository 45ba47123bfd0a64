"""The quadrotor of dynobench and OMPL.app."""

from kinolab.dynamics import (
    Body,
    Control,
    Sphere,
    System,
    Wrench,
    length,
    move,
    orient,
    parameter,
    rotation,
    toward,
)


def quad3d_omplapp() -> System:
    """A quadrotor with one thrust and three torques, as in OMPL.app (dynobench).

    The thrust is relative to the weight, the torques are relative to T.

    Source: Ortiz-Haro and others, dynobench 0.0.4, models/quad3d_omplapp.yaml.
    """
    m, g = parameter("m", 1.0, "kg"), parameter("g", 9.81, "m/s^2")
    J, T = parameter("J", 1.0, "kg m^2"), parameter("T", 20.0, "N m")
    x, y, z = length("x", speed=4.0), length("y", speed=4.0), length("z", speed=4.0)
    R = rotation("R", speed=8.0)
    hull = Body("quadrotor", move(x, y, z) @ orient(R), mass=m, inertia=J, shape=Sphere(0.25))
    lift = Control("f", limit=(0.0, 1.5))
    turns = [Control(name, limit=2.0) for name in ("tx", "ty", "tz")]
    wrench = Wrench(
        on=hull,
        force=(0, 0, lift.symbol * m * g),
        torque=(turns[0].symbol * T, turns[1].symbol * T, turns[2].symbol * T),
    )
    return System(
        "quad3d_omplapp",
        bodies=[hull],
        gravity=toward("-z", g),
        inputs=[lift, *turns],
        efforts=[wrench],
    )
