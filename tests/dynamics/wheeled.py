"""Textbook machines whose coordinate rates determine the motion at some headings only."""

from typing import Any

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


def chaplygin_sleigh(*names: str, **options: Any) -> System:
    """A body on a knife edge, its centre of mass a distance a ahead of the edge.

    Args:
        names: Coordinates whose rates are the velocities; chosen by kinolab when left out.
        options: Of the system.

    Source: Bloch, Nonholonomic Mechanics and Control, 2003, section 1.7.
    """
    m, J = parameter("m", 1.0, "kg"), parameter("J", 0.2, "kg m^2")
    a = parameter("a", 0.3, "m")
    coordinates = {
        "x": length("x", speed=2.0),
        "y": length("y", speed=2.0),
        "theta": angle("theta", speed=3.0),
    }
    edge = move(coordinates["x"], coordinates["y"]) @ rot_z(coordinates["theta"])
    body = Body("sleigh", edge @ move(a, 0), mass=m, inertia=(J, J, J), shape=Box(0.6, 0.3, 0.1))
    if names:
        options["velocities"] = [coordinates[name] for name in names]
    return System(
        "chaplygin_sleigh",
        bodies=[body],
        constraints=[zero(velocity(edge).y, "no sideslip")],
        inputs=[
            Force("push", on=body, along=edge.x, limit=1.0),
            Torque("turn", on=body, about=edge.z, limit=1.0),
        ],
        **options,
    )


def roller_racer(**options: Any) -> System:
    """Two bodies on an axle each, moved by the joint between them.

    Source: Krishnaprasad, Tsakiris, Oscillations, SE(2)-snakes and motion control, Dynamical
    Systems 16, 2001.
    """
    x, y, theta, phi = length("x"), length("y"), angle("theta"), angle("phi")
    seat = move(x, y) @ rot_z(theta)
    bar = seat @ move(0.5, 0) @ rot_z(phi) @ move(-0.2, 0)
    rear = Body("seat", seat, mass=2.0, inertia=(0.1, 0.1, 0.1), shape=Box(0.5, 0.3, 0.1))
    front = Body("bar", bar, mass=0.5, inertia=(0.02, 0.02, 0.02), shape=Box(0.3, 0.1, 0.1))
    return System(
        "roller_racer",
        bodies=[rear, front],
        constraints=[
            zero(velocity(seat).y, "rear axle"),
            zero(velocity(bar).y, "front axle"),
        ],
        inputs=[Torque("twist", on=front, about=bar.z, limit=2.0, reacts_on=rear)],
        **options,
    )


def tractor_with_trailers(**options: Any) -> System:
    """A tractor with two trailers, each hitched behind the axle in front of it.

    Source: Siciliano et al., Robotics: Modelling, Planning and Control, 2009, problem 11.5.
    """
    x, y, theta = length("x"), length("y"), angle("theta")
    alpha, beta = angle("alpha", -1.2, 1.2), angle("beta", -1.2, 1.2)
    front = move(x, y) @ rot_z(theta)
    middle = front @ move(-0.2, 0) @ rot_z(alpha) @ move(-0.6, 0)
    last = middle @ move(-0.1, 0) @ rot_z(beta) @ move(-0.5, 0)
    frames = {"tractor": front, "first": middle, "second": last}
    bodies = [
        Body(name, frame, mass=mass, inertia=(0.1, 0.1, 0.1), shape=Box(0.4, 0.3, 0.2))
        for (name, frame), mass in zip(frames.items(), (5.0, 2.0, 1.0), strict=True)
    ]
    return System(
        "tractor_with_trailers",
        bodies=bodies,
        constraints=[zero(velocity(f).y, f"{name} axle") for name, f in frames.items()],
        inputs=[
            Force("drive", on=bodies[0], along=front.x, limit=10.0),
            Torque("steer", on=bodies[0], about=front.z, limit=3.0),
        ],
        **options,
    )
