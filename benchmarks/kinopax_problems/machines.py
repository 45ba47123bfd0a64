"""The three machines of Kino-PAX: a point mass, a Dubins airplane and a quadrotor.

Source: Perrault, Ho, Lahijanian, Kino-PAX: Highly parallel kinodynamic sampling-based planner, IEEE
Robotics and Automation Letters, 2025, and the numbers of its repository (aria-systems-group/
Kino-PAX). A body is a point there, a tiny sphere here.
"""

import math

import sympy

from kinolab.dynamics import (
    Body,
    Control,
    Rate,
    Sphere,
    State,
    System,
    Wrench,
    angle,
    length,
    move,
    orient,
    rot_y,
    rot_z,
    rotation,
    toward,
    velocity,
    zero,
)


def double_integrator() -> System:
    """Return a point whose acceleration is given: 6 states, in a cube of 1 m."""
    place = [length(name, speed=0.3) for name in "xyz"]
    point = Body("point", move(*place), mass=1.0, inertia=(1e-3,) * 3, shape=Sphere(2e-4))
    pushes = [Control(f"a{name}", limit=0.2, unit="m/s^2") for name in "xyz"]
    force = tuple(push.symbol for push in pushes)
    return System(
        "double_integrator", bodies=[point], inputs=pushes, efforts=[Wrench(on=point, force=force)]
    )


def airplane() -> System:
    """Return a Dubins airplane that turns, pitches and accelerates: 6 states, in a cube of 1 m."""
    x, y, z = length("x"), length("y"), length("z")
    yaw, pitch = angle("yaw"), angle("pitch")
    hull = move(x, y, z) @ rot_z(yaw) @ rot_y(-pitch)
    V, push = velocity(hull), Control("a", limit=0.3, unit="m/s^2")
    return System(
        "airplane",
        bodies=[Body("airplane", hull, shape=Sphere(2e-4))],
        constraints=[zero(V.y, "no sideslip"), zero(V.z, "no heave")],
        states=[
            State("v", push.symbol, velocity=V.x, limits=(0.0, 0.3), unit="m/s", scale=0.3),
        ],
        inputs=[
            push,
            Rate("yaw_rate", on=yaw, limit=math.pi / 4),
            Rate("pitch_rate", on=pitch, limit=math.pi / 4),
        ],
    )


def quadrotor() -> System:
    """Return a rigid body with thrust, three torques and drag: 12 states, in a cube of 100 m.

    The authors' attitude is three Euler angles, here it is a quaternion. The moments of their drag,
    2e-6 of the square of the angular velocity, are left out.
    """
    place = [length(name, speed=30.0) for name in "xyz"]
    hull = move(*place) @ orient(rotation("R", speed=30.0))
    body = Body("quadrotor", hull, mass=1.0, inertia=(1.0, 1.0, 2.0), shape=Sphere(0.02))
    V, thrust = velocity(hull), Control("thrust", limit=(0.0, 30.0), unit="N")
    torques = [Control(name, limit=math.pi, unit="N m") for name in ("roll", "pitch", "yaw")]
    drag = 0.01 * sympy.sqrt(V.x**2 + V.y**2 + V.z**2 + 1e-12)
    return System(
        "quadrotor",
        bodies=[body],
        gravity=toward("-z", 9.81),
        inputs=[thrust, *torques],
        efforts=[
            Wrench(
                on=body,
                force=(-drag * V.x, -drag * V.y, -drag * V.z + thrust.symbol),
                torque=tuple(torque.symbol for torque in torques),
            )
        ],
    )
