"""Machines to test with: random trees of rigid bodies, and the classical constrained ones."""

from functools import cache
from typing import Any

import numpy as np
import sympy as sp

from kinolab.dynamics import (
    WORLD,
    Body,
    Force,
    Frame,
    Gravity,
    Model,
    Sphere,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_x,
    rot_y,
    rot_z,
    velocity,
    zero,
)
from tests.dynamics.reference import Reference

TURNS = {"x": rot_x, "y": rot_y, "z": rot_z}


@cache
def random_machine(seed: int) -> System:
    """A random tree of 1 to 5 bodies with one joint each; every joint moves its own mass."""
    rng = np.random.default_rng(seed)
    a, m = parameter("a", 0.4, "m"), parameter("m", 1.3, "kg")
    g = parameter("g", 9.81, "m/s^2")

    def number(low: float, high: float) -> float:
        return round(float(rng.uniform(low, high)), 3)

    def offset() -> Frame:
        x, y, z = (number(-0.7, 0.7) for _ in range(3))
        return [
            move(x, a * y, z),
            rot_x(x) @ move(0, 0, a),
            rot_z(y) @ rot_y(x),
            WORLD,
        ][rng.integers(4)]

    coordinates: list[Any] = []
    frames, bodies = [WORLD], []
    for k in range(int(rng.integers(1, 6))):
        axis = "xyz"[rng.integers(3)]
        slides = bool(rng.integers(3) == 0)
        q = length(f"q_{k}") if slides else angle(f"q_{k}")
        shapes = [q, 2 * q, -q, q + sp.sin(q) / 3, q + 0.2 * q**3, sp.exp(q / 4), q / 3 - a]
        motion = shapes[rng.integers(len(shapes))]
        joint = move(**{axis: motion}) if slides else TURNS[axis](motion)
        other = coordinates[rng.integers(len(coordinates))] if coordinates else 0
        bump = move(0, number(0.1, 0.4) * sp.sin(other), 0) if rng.integers(2) else WORLD
        parent = frames[rng.integers(len(frames))]
        hinge = parent @ offset() @ bump @ joint
        place = hinge @ offset()
        edges = [number(0.05, 0.6) for _ in range(3)]  # semi-axes of a solid with this inertia
        inertia = tuple(sum(edges) - edge for edge in edges)
        mass = m * number(0.3, 2.0) if rng.integers(2) else number(0.3, 2.0)
        bodies.append(Body(f"b{k}", place, mass=mass, inertia=inertia, shape=Sphere(a)))
        coordinates.append(q)
        frames += [hinge, place]
    inputs: list[Any] = []
    for k in range(int(rng.integers(0, 4))):
        on = bodies[rng.integers(len(bodies))]
        others = [None, *(body for body in bodies if body is not on)]
        back = others[rng.integers(len(others))]
        axis_of = getattr(frames[rng.integers(len(frames))], "xyz"[rng.integers(3)])
        if rng.integers(2):
            inputs.append(Torque(f"u{k}", on=on, about=axis_of, reacts_on=back, limit=2.0))
        else:
            inputs.append(Force(f"u{k}", on=on, along=axis_of, reacts_on=back, limit=2.0))
    down = rng.normal(size=3)
    x, y, z = (float(d) for d in down / np.linalg.norm(down))
    field = Gravity((x, y, z), g) if rng.integers(4) else None
    whole = System(f"random_{seed}", bodies=bodies, inputs=inputs, gravity=field)
    return System(whole.name, bodies=bodies, inputs=useful(whole), gravity=field)


def useful(system: System) -> list[Any]:
    """The inputs that do work in some motion; one that reaches nothing is refused."""
    reference, rng = Reference(system), np.random.default_rng(0)
    at = [reference.input_matrix(rng.uniform(-1, 1, reference.size)) for _ in range(3)]
    reaches = np.abs(at).max(axis=(0, 1)) > 1e-12  # [m] or 1: rounding of frames of size 1
    return [entry for entry, yes in zip(system.inputs, reaches, strict=True) if yes]


def knife_edge() -> System:
    """A sledge on a tilted plane that cannot slip sideways."""
    x, y, th = length("x"), length("y"), angle("th")
    m, g = parameter("m", 1.7, "kg"), parameter("g", 9.81, "m/s^2")
    blade = move(x, y) @ rot_z(th)
    sledge = Body("sledge", blade, mass=m, inertia=(0.1, 0.2, 0.25))
    return System(
        "knife_edge",
        bodies=[sledge],
        constraints=[zero(velocity(blade).y, "edge")],
        velocities=[x, th],
        gravity=Gravity((0.6, 0.0, -0.8), g),
        inputs=[
            Force("push", on=sledge, along=blade.x, limit=1),
            Torque("turn", on=sledge, about=blade.z, limit=1),
        ],
    )


def cart(I_wheel: float = 0.02) -> System:
    """A differential drive: chassis and two wheels; three rolling constraints."""
    r, b = parameter("r", 0.0975, "m"), parameter("b", 0.33, "m")
    x, y, psi = length("x"), length("y"), angle("psi")
    left, right = angle("left"), angle("right")
    chassis = move(x, y, r) @ rot_z(psi)
    body = Body("chassis", chassis, mass=8.0, inertia=(0.3, 0.3, 0.4))
    hubs = [chassis @ move(0, side * b / 2, 0) for side in (1, -1)]
    wheels = [
        Body(name, hub @ rot_y(q), mass=0.5, inertia=(I_wheel / 2, I_wheel, I_wheel / 2))
        for name, hub, q in zip(("wheel_l", "wheel_r"), hubs, (left, right), strict=True)
    ]
    return System(
        "cart",
        bodies=[body, *wheels],
        constraints=[
            zero(velocity(chassis).y, "no sideslip"),
            zero(velocity(hubs[0]).x - r * rate(left), "left rolls"),
            zero(velocity(hubs[1]).x - r * rate(right), "right rolls"),
        ],
        inputs=[
            Torque("tau_l", on=wheels[0], about=hubs[0].y, reacts_on=body, limit=1),
            Torque("tau_r", on=wheels[1], about=hubs[1].y, reacts_on=body, limit=1),
        ],
    )


def snakeboard() -> System:
    """Board, rotor and two wheel sets that steer apart by independent angles.

    Source: Lewis, Ostrowski, Murray, Burdick, ICRA 1994.
    """
    m, J, Jr, Jw = 6.0, 6.0 * 0.2**2 - 0.072 - 2 * 0.0013, 0.072, 0.0013
    half = parameter("l", 0.2, "m")
    x, y, th = length("x"), length("y"), angle("th")
    psi = angle("psi")
    phi_b, phi_f = angle("phi_b", -1.5, 1.5), angle("phi_f", -1.5, 1.5)
    board = move(x, y) @ rot_z(th)
    back, front = (board @ move(s * half) for s in (-1, 1))
    bodies = [
        Body("board", board, mass=m, inertia=(J, J, J)),
        Body("rotor", board @ rot_z(psi), mass=0, inertia=Jr),
        # The wheels' mass counts as the board's, their spin inertia is their own.
        Body("rear", back @ rot_z(phi_b), mass=0, inertia=Jw),
        Body("fore", front @ rot_z(phi_f), mass=0, inertia=Jw),
    ]
    return System(
        "snakeboard",
        bodies=bodies,
        constraints=[
            zero(velocity(back @ rot_z(phi_b)).y, "rear wheels"),
            zero(velocity(front @ rot_z(phi_f)).y, "front wheels"),
        ],
        velocities=[th, psi, phi_b, phi_f],
        inputs=[
            Torque("tau_psi", on=bodies[1], about=board.z, reacts_on=bodies[0], limit=1),
            Torque("tau_b", on=bodies[2], about=board.z, reacts_on=bodies[0], limit=1),
            Torque("tau_f", on=bodies[3], about=board.z, reacts_on=bodies[0], limit=1),
        ],
    )


def road_train() -> System:
    """A rolling tractor with three trailers: five constraints on seven coordinates."""
    x, y, phi = length("x"), length("y"), angle("phi")
    headings = [angle(f"th_{i}", -1.0, 1.0) for i in range(4)]
    axle = move(x, y) @ rot_z(headings[0])
    axles = [axle]
    for i, heading in enumerate(headings[1:], 1):
        hitch = axles[-1] @ move(-0.1 * i)
        axles.append(hitch @ rot_z(heading) @ move(-0.5 - 0.1 * i))
    bodies = [
        Body(f"cart_{i}", a, mass=1.0 + i, inertia=(0.1, 0.2, 0.25)) for i, a in enumerate(axles)
    ]
    bodies.append(Body("wheel", axle @ rot_y(phi), mass=0.4, inertia=(0.01, 0.02, 0.01)))
    slips = [zero(velocity(a).y, f"axle {i}") for i, a in enumerate(axles)]
    return System(
        "road_train",
        bodies=bodies,
        constraints=[*slips, zero(velocity(axle).x - 0.3 * rate(phi), "rolling")],
        inputs=[
            Torque("drive", on=bodies[-1], about=axle.y, reacts_on=bodies[0], limit=1),
            Torque("steer", on=bodies[0], about=axle.z, limit=1),
        ],
    )


CONSTRAINED = {
    "knife_edge": knife_edge,
    "cart": cart,
    "snakeboard": snakeboard,
    "road_train": road_train,
}


@cache
def compiled_random(seed: int) -> Model:
    return random_machine(seed).model()


@cache
def reference_of(seed: int) -> Reference:
    """The same random machine by other means; what it compiles serves all laws."""
    return Reference(compiled_random(seed).system)


@cache
def compiled(name: str) -> Model:
    return CONSTRAINED[name]().model()
