"""Chaplygin's sleigh: a body on a runner, its centre of mass ahead of it."""

from kinolab.dynamics import (
    Body,
    Box,
    Force,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rot_z,
    velocity,
    zero,
)


def chaplygin_sleigh() -> System:
    """A sleigh that is pushed along its runner and turned by a flywheel."""
    m, J, a = parameter("m", 4.0, "kg"), parameter("J", 0.3, "kg m^2"), parameter("a", 0.2, "m")
    x, y, theta = length("x", speed=2.0), length("y", speed=2.0), angle("theta", speed=3.0)
    runner = move(x, y, 0.1) @ rot_z(theta)
    body = Body("sleigh", runner @ move(a, 0), mass=m, inertia=J, shape=Box(0.6, 0.3, 0.1))
    return System(
        "chaplygin_sleigh",
        bodies=[body],
        constraints=[zero(velocity(runner).y, "no sideslip")],
        inputs=[
            Force("push", on=body, along=runner.x, limit=4.0),
            Torque("turn", on=body, about=runner.z, limit=0.6),
        ],
    )
