"""OMPL.app's machines, each a rigid body of the user's own shape.

Source: omplapp 1.7, src/omplapp/apps: the equations in the headers of KinematicCarPlanning,
DynamicCarPlanning, BlimpPlanning and QuadrotorPlanning, and the limits in setDefaultBounds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import sympy

from kinolab.dynamics import (
    Body,
    Control,
    Force,
    Rate,
    State,
    System,
    Torque,
    Viscous,
    Wrench,
    angle,
    length,
    move,
    orient,
    parameter,
    rate,
    rot_z,
    rotation,
    toward,
    velocity,
    zero,
)
from kinolab.dynamics.language.frames import Frame
from kinolab.dynamics.language.shapes import Shape

Part: TypeAlias = tuple[Frame, Sequence[Shape]]  # shapes along the axes of a frame in the body
Parts: TypeAlias = Sequence[Part]  # the first one's frame is the body's own
NAME = "robot"  # of the body


def planar_body(parts: Parts, speed: float, turning: float) -> System:
    """Return a rigid body in the plane whose velocities are its inputs.

    Args:
        parts: Its shape about the point that its coordinates are of.
        speed: Largest magnitude of the rates of x and y, in [m/s].
        turning: Largest turn rate, in [rad/s].
    """
    x, y, theta = length("x"), length("y"), angle("theta")
    return System(
        "planar_body",
        bodies=_bodies(move(x, y) @ rot_z(theta), parts),
        inputs=[
            Rate("vx", on=x, limit=speed),
            Rate("vy", on=y, limit=speed),
            Rate("w", on=theta, limit=turning),
        ],
    )


def free_body(parts: Parts, speed: float, turning: float) -> System:
    """Return a rigid body in space whose velocities are its inputs.

    Args:
        parts: Its shape about the point that its coordinates are of.
        speed: Largest magnitude of the rates of x, y and z, in [m/s].
        turning: Largest magnitude of the turn rates about its own axes, in [rad/s].
    """
    place, R = [length(name) for name in "xyz"], rotation("R")
    frame = move(*place) @ orient(R)
    V = velocity(frame)
    return System(
        "free_body",
        bodies=_bodies(frame, parts),
        inputs=[
            *(Rate(f"v{q.name}", on=q, limit=speed) for q in place),
            *(Rate(f"w{k}", on=on, limit=turning) for k, on in zip("xyz", V.angular, strict=True)),
        ],
    )


def kinematic_car(
    parts: Parts,
    speed: tuple[float, float] = (-5.0, 5.0),
    steering: float = math.pi / 6,
    wheelbase: float = 1.0,
) -> System:
    """Return a car whose speed and steering angle are its inputs.

    It is theta_dot = v tan(phi) / L, as neither axle slips sideways.

    Args:
        parts: Its shape about the middle of the rear axle.
        speed: Lowest and highest, in [m/s].
        steering: Largest steering angle, in [rad].
        wheelbase: L, in [m].
    """
    L = parameter("L", wheelbase, "m")
    x, y, theta = length("x"), length("y"), angle("theta")
    rear = move(x, y) @ rot_z(theta)
    phi = Control("phi", limit=steering, unit="rad")
    V, front = velocity(rear), velocity(rear @ move(L))
    across = front.y * sympy.cos(phi.symbol) - front.x * sympy.sin(phi.symbol)
    return System(
        "kinematic_car",
        bodies=_bodies(rear, parts),
        constraints=[zero(V.y, "no sideslip behind"), zero(across, "no sideslip in front")],
        inputs=[Rate("v", on=V.x, limit=speed), phi],
    )


def dynamic_car(parts: Parts) -> System:
    """Return a car whose acceleration and steering rate are its inputs.

    OMPL.app's factor m of the turn rate, which it calls a mass, is 1, and so is the wheelbase.

    Args:
        parts: Its shape about the middle of the rear axle.
    """
    L = parameter("L", 1.0, "m")
    x, y, theta = length("x"), length("y"), angle("theta")
    phi = angle("phi", -math.pi / 6, math.pi / 6)  # steering angle
    rear = move(x, y) @ rot_z(theta)
    front = rear @ move(L) @ rot_z(phi)
    a, V = Control("a", limit=0.5, unit="m/s^2"), velocity(rear)
    return System(
        "dynamic_car",
        bodies=_bodies(rear, parts),
        constraints=[
            zero(V.y, "no sideslip behind"),
            zero(velocity(front).y, "no sideslip in front"),
        ],
        states=[State("v", a.symbol, velocity=V.x, limits=(-1.0, 1.0), unit="m/s")],
        inputs=[a, Rate("phi_rate", on=phi, limit=math.pi / 90)],
    )


def blimp(parts: Parts) -> System:
    """Return a blimp, which floats without drag: a thrust ahead, one upward, a torque about z.

    With a mass of 1 kg and a moment of inertia of 1 kg m^2, inputs are the accelerations.

    Args:
        parts: Its shape about its centre of mass.
    """
    x, y, z = (length(name, speed=1.0) for name in "xyz")
    theta = angle("theta", speed=0.2)
    hull = move(x, y, z) @ rot_z(theta)
    bodies = _bodies(hull, parts, mass=1.0, inertia=1.0)
    return System(
        "blimp",
        bodies=bodies,
        inputs=[
            Force("u_f", on=bodies[0], along=hull.x, limit=1.0),
            Force("u_z", on=bodies[0], along=hull.z, limit=1.0),
            Torque("u_theta", on=bodies[0], about=hull.z, limit=0.3),
        ],
    )


def quadrotor(parts: Parts) -> System:
    """Return a quadrotor whose thrust pushes along minus the z axis of its body.

    It hovers upside down. The air's resistance is proportional to its velocity. With moments of
    inertia of 1 kg m^2, its torques are angular accelerations, about the body's axes.

    Args:
        parts: Its shape about its centre of mass.
    """
    m, beta = parameter("m", 1.0, "kg"), parameter("beta", 1.0, "N s/m")
    place = [length(name, speed=1.0) for name in "xyz"]
    R = rotation("R", speed=1.0)
    bodies = _bodies(move(*place) @ orient(R), parts, mass=m, inertia=1.0)
    thrust = Control("u0", limit=(5.0, 15.0), unit="N")
    turns = [Control(f"u{k}", limit=1.0, unit="N m") for k in (1, 2, 3)]
    wrench = Wrench(
        on=bodies[0],
        force=(0, 0, -thrust.symbol),
        torque=(turns[0].symbol, turns[1].symbol, turns[2].symbol),
    )
    return System(
        "quadrotor",
        bodies=bodies,
        gravity=toward("-z", 9.81),
        inputs=[thrust, *turns],
        efforts=[wrench, *(Viscous(rate(q), beta) for q in place)],
    )


def _bodies(
    frame: Frame, parts: Parts, *, mass: sympy.Expr | float = 0.0, inertia: float = 0.0
) -> list[Body]:
    """Return a body with its first part; what is turned in it are bodies of their own."""
    (own, shapes), *turned = parts
    return [
        Body(NAME, frame @ own, mass=mass, inertia=inertia, shape=shapes),
        *(
            Body(f"{NAME} {k}", frame @ part, shape=shapes)
            for k, (part, shapes) in enumerate(turned, start=2)
        ),
    ]
