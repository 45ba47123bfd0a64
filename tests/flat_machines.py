"""Ten machines of textbooks, and what the literature says of their flatness.

They were written before the search for flat outputs, which is not to know their names.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from sympy import cos, sin

from kinolab.dynamics import (
    WORLD,
    Body,
    Buoyancy,
    Control,
    Drive,
    Force,
    Rate,
    System,
    Torque,
    Viscous,
    Wrench,
    angle,
    homogeneous,
    length,
    move,
    orient,
    parameter,
    rate,
    rot_y,
    rot_z,
    rotation,
    toward,
    velocity,
    zero,
)


def pvtol() -> System:
    """An aircraft that takes off vertically; what rolls it pushes it sideways, too."""
    g = parameter("g", 9.81, "m/s^2")
    x, z, theta = length("x"), length("z"), angle("theta")
    body = Body("aircraft", move(x, 0, z) @ rot_y(theta), mass=2.0, inertia=0.5)
    lift, roll = Control("lift", limit=(0.0, 40.0)), Control("roll", limit=5.0)
    push = Wrench(on=body, force=(roll.symbol, 0, lift.symbol), at=(0, 0, -0.4))
    return System(
        "pvtol", bodies=[body], gravity=toward("-z", g), inputs=[lift, roll], efforts=[push]
    )


def quadrotor_with_pendulum() -> System:
    """A quadrotor in a vertical plane, from whose centre a rod with mass and inertia hangs."""
    g = parameter("g", 9.81, "m/s^2")
    x, z, theta, phi = length("x"), length("z"), angle("theta"), angle("phi")
    at = move(x, 0, z)
    hull = Body("hull", at @ rot_y(theta), mass=1.2, inertia=0.02)
    rod = Body("rod", at @ rot_y(phi) @ move(0, 0, -0.5), mass=0.4, inertia=0.03)
    lift, turn = Control("lift", limit=(0.0, 40.0)), Control("turn", limit=2.0)
    push = Wrench(on=hull, force=(0, 0, lift.symbol), torque=(0, turn.symbol, 0))
    return System(
        "quadrotor_with_pendulum",
        bodies=[hull, rod],
        gravity=toward("-z", g),
        inputs=[lift, turn],
        efforts=[push],
    )


def truck_with_two_trailers() -> System:
    """A truck that is moved at a speed and a steering rate; each trailer hangs on an axle."""
    x, y = length("x"), length("y")  # middle of the last axle
    psi_2, psi_1, psi_0 = angle("psi_2"), angle("psi_1"), angle("psi_0")
    delta = angle("delta", -1.0, 1.0)
    last = move(x, y) @ rot_z(psi_2)
    middle = last @ move(3.0) @ rot_z(psi_1 - psi_2)
    truck = middle @ move(2.5) @ rot_z(psi_0 - psi_1)
    front = truck @ move(4.0) @ rot_z(delta)
    return System(
        "truck_with_two_trailers",
        bodies=[Body("trailer 2", last), Body("trailer 1", middle), Body("truck", truck)],
        constraints=[
            zero(velocity(frame).y, f"no sideslip {k}")
            for k, frame in enumerate((last, middle, truck, front))
        ],
        inputs=[Rate("v", on=velocity(truck).x, limit=2.0), Rate("steer", on=delta, limit=1.0)],
    )


def hovercraft() -> System:
    """A hovercraft with a fan astern and a yaw torque, which the air drags alike in all ways."""
    x, y, psi = length("x"), length("y"), angle("psi")
    craft = Body("hull", move(x, y) @ rot_z(psi), mass=3.0, inertia=0.4)
    return System(
        "hovercraft",
        bodies=[craft],
        inputs=[
            Force("fan", on=craft, along=craft.frame.x, limit=5.0),
            Torque("rudder", on=craft, about=craft.frame.z, limit=1.0),
        ],
        efforts=[Viscous(rate(x), 0.8), Viscous(rate(y), 0.8), Viscous(rate(psi), 0.1)],
    )


def gantry_with_double_pendulum() -> System:
    """A trolley that is pushed; from it hang a hook and below it a load, both on rods."""
    g = parameter("g", 9.81, "m/s^2")
    x, hook, load = length("x"), angle("hook"), angle("load")
    trolley, joint = move(x), move(x) @ rot_y(hook) @ move(0, 0, -2.0)
    bodies = [
        Body("trolley", trolley, mass=4.0),
        Body("hook", joint, mass=1.0),
        Body("load", joint @ rot_y(load) @ move(0, 0, -1.0), mass=2.0),
    ]
    return System(
        "gantry_with_double_pendulum",
        bodies=bodies,
        gravity=toward("-z", g),
        inputs=[Force("push", on=bodies[0], along=WORLD.x, limit=50.0)],
    )


def kinematic_bicycle() -> System:
    """A bicycle in the plane, of given speed and given steering angle."""
    x, y, psi = length("x"), length("y"), angle("psi")
    rear = move(x, y) @ rot_z(psi)
    steer = Control("steer", limit=0.7, unit="rad")
    V, front = velocity(rear), velocity(rear @ move(1.1))
    return System(
        "kinematic_bicycle",
        bodies=[Body("frame", rear @ move(0.5))],
        constraints=[
            zero(V.y, "no sideslip behind"),
            zero(front.y * cos(steer.symbol) - front.x * sin(steer.symbol), "none in front"),
        ],
        inputs=[Rate("v", on=V.x, limit=5.0), steer],
    )


def vtol_with_tail_rotor() -> System:
    """A helicopter seen from behind: its tail rotor pushes it aside, above the centre of mass."""
    g = parameter("g", 9.81, "m/s^2")
    y, z, phi = length("y"), length("z"), angle("phi")
    body = Body("fuselage", move(y, 0, z) @ rot_y(phi), mass=8.0, inertia=0.2)
    main, tail = Control("main", limit=(0.0, 140.0)), Control("tail", limit=12.0)
    return System(
        "vtol_with_tail_rotor",
        bodies=[body],
        gravity=toward("-z", g),
        inputs=[main, tail],
        efforts=[
            Wrench(on=body, force=(0, 0, main.symbol), at=(0, 0, 0.3)),
            Wrench(on=body, force=(tail.symbol, 0, 0), at=(0, 0, 0.1)),
        ],
    )


def ball_on_plate() -> System:
    """A ball that rolls under a plate without slipping or spinning; the plate's speeds are given.

    Its orientation counts, and not only where it is.
    """
    x, y, R = length("x"), length("y"), rotation("R")
    ball = move(x, y, 0.1) @ orient(R)
    wx, wy, wz = homogeneous(ball)[:3, :3] * velocity(ball).angular
    return System(
        "ball_on_plate",
        bodies=[Body("ball", ball)],
        constraints=[
            zero(rate(x) - 0.1 * wy, "rolling along x"),
            zero(rate(y) + 0.1 * wx, "rolling along y"),
            zero(wz, "no spin"),
        ],
        inputs=[Rate("u", on=rate(x), limit=1.0), Rate("v", on=rate(y), limit=1.0)],
    )


def scara_with_payload() -> System:
    """An arm with two upright axes, a spindle that turns and slides, and a payload beside it."""
    g = parameter("g", 9.81, "m/s^2")
    a, b, c, d = angle("a"), angle("b"), angle("c"), length("d", -0.4, 0.0)
    first = rot_z(a)
    second = first @ move(0.4) @ rot_z(b)
    spindle = second @ move(0.3) @ rot_z(c) @ move(0, 0, d)
    arm = Body("arm", first @ move(0.2), mass=5.0, inertia=0.1)
    forearm = Body("forearm", second @ move(0.15), mass=3.0, inertia=0.05)
    payload = Body("payload", spindle @ move(0.05), mass=2.0, inertia=0.01)
    return System(
        "scara_with_payload",
        bodies=[arm, forearm, payload],
        gravity=toward("-z", g),
        inputs=[
            Torque("shoulder", on=arm, about=WORLD.z, limit=50.0),
            Torque("elbow", on=forearm, about=first.z, limit=30.0, reacts_on=arm),
            Torque("wrist", on=payload, about=second.z, limit=5.0, reacts_on=forearm),
            Force("lift", on=payload, along=second.z, limit=60.0, reacts_on=forearm),
        ],
        efforts=[Viscous(rate(a), 0.3), Viscous(rate(b), 0.2)],
    )


def underwater_glider() -> System:
    """A glider in a vertical plane, of fixed net weight, steered by a battery that slides in it."""
    g = parameter("g", 9.81, "m/s^2")
    x, z, theta, s = length("x"), length("z"), angle("theta"), length("s", -0.3, 0.3)
    hull = move(x, 0, z) @ rot_y(theta)
    glider = Body("hull", hull, mass=40.0, inertia=9.0, added_mass=(2.0, 50.0, 50.0, 0.5, 8.0, 8.0))
    battery = Body("battery", hull @ move(s, 0, -0.05), mass=9.0)
    V = velocity(hull)
    force = (-6.0 * V.x, 0, -120.0 * V.z)  # of the water: drag along the hull, lift across it
    return System(
        "underwater_glider",
        bodies=[glider, battery],
        gravity=toward("-z", g),
        inputs=[Force("shift", on=battery, along=hull.x, limit=20.0, reacts_on=glider)],
        efforts=[
            Buoyancy(on=glider, lift=48.0 * g),
            Wrench(on=glider, force=force, torque=(0, -30.0 * V.wy, 0)),
        ],
    )


def gantry_with_hoist() -> System:
    """The gantry with a double pendulum again, whose trolley also hoists the hook."""
    g = parameter("g", 9.81, "m/s^2")
    x, l, hook, load = length("x"), length("l", 1.0, 4.0), angle("hook"), angle("load")  # noqa: E741
    joint = move(x) @ rot_y(hook) @ move(0, 0, -l)
    return System(
        "gantry_with_hoist",
        bodies=[
            Body("trolley", move(x), mass=4.0),
            Body("hook", joint, mass=1.0),
            Body("load", joint @ rot_y(load) @ move(0, 0, -1.0), mass=2.0),
        ],
        gravity=toward("-z", g),
        inputs=[Drive("travel", on=x, limit=2.0), Drive("hoist", on=l, limit=2.0)],
    )


@dataclass(frozen=True)
class Answer:
    """What the literature says of a machine.

    Attributes:
        machine: Returns it.
        flat: Whether it is flat, as it is modelled.
        orders: Number of derivatives of its flat outputs that states and inputs need, of each.
        source: Where that stands, or the theorem from which it follows.
    """

    machine: Callable[[], System]
    flat: bool
    orders: tuple[int, ...]
    source: str


MARTIN_DEVASIA_PADEN = "Martin, Devasia, Paden, Automatica 32(1), 1996: Huygens' centre"
CHARLET = "not static feedback linearisable: Charlet, Levine, Marino, Syst. Control Lett. 13, 1989"
TEN = (
    Answer(pvtol, True, (4, 4), MARTIN_DEVASIA_PADEN),
    Answer(
        quadrotor_with_pendulum,
        True,
        (6, 6),
        "Sreenath, Michael, Kumar, ICRA 2013, of a point mass; of a rod its centre of oscillation",
    ),
    Answer(
        truck_with_two_trailers,
        True,
        (5, 5),
        "Rouchon, Fliess, Levine, Martin, ECC 1993: the middle of the last axle",
    ),
    Answer(hovercraft, True, (4, 4), "Sira-Ramirez, Ibanez, Int. J. Control 73(7), 2000"),
    Answer(gantry_with_double_pendulum, False, (), CHARLET),
    Answer(
        kinematic_bicycle,
        True,
        (2, 2),
        "Fliess, Levine, Martin, Rouchon, Int. J. Control 61(6), 1995, section 4: the rear axle",
    ),
    Answer(vtol_with_tail_rotor, True, (4, 4), MARTIN_DEVASIA_PADEN),
    Answer(
        ball_on_plate,
        False,
        (),
        "growth (2, 3, 5): Martin, Rouchon, Feedback linearization and driftless systems, 1994",
    ),
    Answer(
        scara_with_payload,
        True,
        (2, 2, 2, 2),
        "Murray, Rathinam, Sluis, Differential flatness of mechanical control systems, 1995",
    ),
    Answer(underwater_glider, False, (), CHARLET),
)
