"""Machines with one mistake each: right when nothing is planted, and wrong in a named way else."""

from __future__ import annotations

from typing import Any

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Capsule,
    Cylinder,
    Disk,
    Force,
    Sphere,
    System,
    Torque,
    Viscous,
    Wrench,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    toward,
    velocity,
    zero,
)


def coin(**other: Any) -> System:
    """A coin that rolls upright, with some of its parts exchanged."""
    m, R = parameter("m", other.get("mass", 0.5), "kg"), parameter("R", 0.2, "m")
    x, y, psi, phi = length("x"), length("y"), angle("psi"), angle("phi", speed=9.0)
    fork = move(x, y, R) @ rot_z(psi)
    frame = other.get("frame", fork @ rot_y(phi))
    if other.get("swapped"):
        frame = move(x, y, R) @ rot_y(phi) @ rot_z(psi)
    body = Body(
        "coin",
        frame,
        mass=m,
        inertia=other.get("inertia", (m * R**2 / 4, m * R**2 / 2, m * R**2 / 4)),
        shape=Disk(other.get("radius", R), 0.02, axis="y"),
        touches_ground=True,
    )
    V = velocity(fork)
    forward = rate(x) if other.get("along_x") else V.x
    roll = zero(forward - other.get("sign", 1) * other.get("rolls", R) * rate(phi), "rolling")
    side = zero(V.y, "no sideslip")
    kept = [c for c in (side, roll) if c.name not in other.get("without", ())]
    steer_about = body.frame.z if other.get("own_axis") else fork.z
    return System(
        "coin",
        bodies=[body],
        constraints=kept,
        gravity=toward(other.get("down", "-z"), other.get("g", 9.81)),
        inputs=[
            Torque("drive", on=body, about=fork.y, limit=1.0),
            Torque("steer", on=body, about=steer_about, limit=1.0),
        ],
        efforts=[Wrench(on=body, force=(other.get("push", 0) * V.x, 0, 0))] * ("push" in other),
        expected=other.get("expected", ()),
    )


def arm(**other: Any) -> System:
    """Two links in a vertical plane with a motor at each joint."""
    a, b = angle("a", *other.get("limits", (-2.0, 2.0)), speed=5.0), angle("b", speed=5.0)
    reach, turn = parameter("l", other.get("l", 0.4), "m"), other.get("turn", 0)
    shoulder = move(0, 0, 1) @ rot_y(a)
    elbow = shoulder @ move(reach) @ rot_y(b + turn)
    if other.get("swapped"):
        elbow = move(0, 0, 1) @ move(reach) @ rot_y(a) @ rot_y(b)
    rod = Capsule(0.02, reach, axis="x")
    upper, fore = (
        Body(name, joint @ move(reach / 2), mass=mass, inertia=mass * 0.4**2 / 12, shape=rod)
        for name, joint, mass in (("upper", shoulder, 1.0), ("fore", elbow, other.get("m", 0.5)))
    )
    reacts = None if other.get("alone") else upper
    return System(
        "arm",
        bodies=[upper, fore],
        gravity=toward(other.get("down", "-z")),
        inputs=[
            Torque("first", on=upper, about=WORLD.y, limit=9.0),
            Torque("second", on=fore, about=elbow.y, limit=3.0, reacts_on=reacts),
        ],
        efforts=[
            Wrench(on=fore, torque=(0, other.get("push", -0.1) * rate(b), 0), reacts_on=upper)
        ],
    )


def cart(**other: Any) -> System:
    """A cart on two wheels that a motor drives along a line, with a slider on it."""
    x, s = length("x", speed=2.0), length("s", -0.3, 0.3, speed=1.0)
    phi, r = angle("phi", speed=20.0), parameter("r", 0.1, "m")
    axle = move(x, 0, r)
    hull = Body("hull", axle @ move(0, 0, 0.2), mass=5.0, shape=Box(0.8, 0.3, 0.1))
    sizes = (other.get("radius", r), 0.04)
    wheel = Body(
        "wheel",
        axle @ rot_y(other.get("way", 1) * phi),
        mass=other.get("mass", 0.5),
        inertia=other.get("inertia", 0.0025),
        shape=Cylinder(*sizes, axis="y"),
        touches_ground=True,
    )
    slider = Body("slider", axle @ move(s, 0, 0.3), mass=1.0, shape=Box(0.1, 0.1, 0.1))
    roll = zero(rate(x) - other.get("rolls", r) * rate(phi), "rolling")
    base = None if other.get("alone") else hull
    return System(
        "cart",
        bodies=[hull, wheel, slider],
        constraints=[] if other.get("free") else [roll],
        gravity=toward(other.get("down", "-z")),
        inputs=[
            Torque("motor", on=wheel, about=axle.y, limit=2.0),
            Force("slide", on=slider, along=axle.x, limit=5.0, reacts_on=base),
        ],
        efforts=[Viscous(rate(s), 0.1)],
    )


def ball(**other: Any) -> System:
    """A ball that rolls in a straight gutter on a table."""
    x, phi, R = length("x", -1, 1, speed=1.0), angle("phi", speed=50.0), parameter("R", 0.05, "m")
    table = Body("table", move(0, 0, 0.7), shape=Box(3.0, 1.0, other.get("thick", 0.04)))
    stone = Body(
        "stone",
        move(x, 0, 0.72 + R) @ rot_y(phi),
        mass=other.get("mass", 0.4),
        inertia=other.get("inertia", 0.4 * 0.4 * 0.05**2),
        shape=Sphere(other.get("radius", R)),
    )
    return System(
        "ball",
        bodies=[table, stone],
        constraints=[] if other.get("free") else [zero(rate(x) - R * rate(phi), "rolling")],
        gravity=toward(other.get("down", "-z")),
        inputs=[Force("push", on=stone, along=WORLD.x, limit=1.0)],
    )
