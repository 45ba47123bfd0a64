"""Franka Emika's arm with seven joints and a hand, which carries a can."""

from __future__ import annotations

from collections.abc import Sequence

from sympy import Expr, Integer, Matrix, pi, zeros

from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Capsule,
    Cylinder,
    Feedback,
    Frame,
    Reference,
    Shape,
    System,
    Torque,
    angle,
    homogeneous,
    move,
    parameter,
    rate,
    rot_x,
    rot_y,
    rot_z,
    toward,
)

# Of each joint: limits in [rad], speed in [rad/s], torque in [N m].
JOINTS = (
    (-2.8973, 2.8973, 2.175, 87.0),
    (-1.7628, 1.7628, 2.175, 87.0),
    (-2.8973, 2.8973, 2.175, 87.0),
    (-3.0718, -0.0698, 2.175, 87.0),
    (-2.8973, 2.8973, 2.61, 12.0),
    (-0.0175, 3.7525, 2.61, 12.0),
    (-2.8973, 2.8973, 2.61, 12.0),
)
# Of each link: mass in [kg], centre of mass in [m], and about it Ixx, Iyy, Izz, Ixy, Ixz, Iyz in
# [kg m^2], all in the axes of its joint.
LINKS = (
    (4.970684, (0.003875, 0.002081, -0.04762),
     (0.70337, 0.70661, 0.009117, -0.000139, 0.006772, 0.019169)),
    (0.646926, (-0.003141, -0.02872, 0.003495),
     (0.007962, 0.02811, 0.025995, -0.003925, 0.010254, 0.000704)),
    (3.228604, (0.027518, 0.039252, -0.066502),
     (0.037242, 0.036155, 0.01083, -0.004761, -0.011396, -0.012805)),
    (3.587895, (-0.05317, 0.104419, 0.027454),
     (0.025853, 0.019552, 0.028323, 0.007796, -0.001332, 0.008641)),
    (1.225946, (-0.011953, 0.041065, -0.038437),
     (0.035549, 0.029474, 0.008627, -0.002117, -0.004037, 0.000229)),
    (1.666555, (0.060149, -0.014117, -0.010517),
     (0.001964, 0.004354, 0.005433, 0.000109, -0.001158, 0.000341)),
    (0.735522, (0.010517, -0.004252, 0.061597),
     (0.012516, 0.010027, 0.004815, -0.000428, -0.001196, -0.000741)),
)  # fmt: skip
HAND = (0.73, (-0.01, 0.0, 0.03), (0.001, 0.0025, 0.0017, 0.0, 0.0, 0.0))
SHAPES: tuple[tuple[Shape, ...], ...] = (  # around the robot's own surface, to within 5 mm
    (Capsule(0.06, 0.19, at=(0, 0, -0.1)),),
    (Cylinder(0.057, 0.262),),
    (Capsule(0.06, 0.15, at=(0, 0, -0.145)),),
    (Capsule(0.06, 0.12),),
    (Capsule(0.06, 0.10, at=(0, 0, -0.26)), Capsule(0.055, 0.21, at=(0, 0.075, -0.1))),
    (Capsule(0.05, 0.08, at=(0, 0, -0.03)), Capsule(0.062, 0.07, axis="y", at=(0.07, 0.02, 0.005))),
    (Capsule(0.045, 0.1, at=(0, 0, 0.035)), Capsule(0.045, 0.02, at=(0.045, 0.045, 0.08))),
)
BASE = (Cylinder(0.08, 0.14, at=(0, 0, 0.07)), Box(0.12, 0.14, 0.1, at=(-0.09, 0, 0.05)))
PITCH = pi / 4  # of the can between the fingers: the hand comes from above
WHITE, DARK, RED = (0.93, 0.93, 0.92), (0.25, 0.26, 0.28), (0.75, 0.13, 0.11)


def panda() -> System:
    """Seven motors move a can that a hand holds; all of them have limited torques.

    Angles q1 to q7 are the robot's own. The can is upright where the hand points forwards and down
    by 45 degrees. Its mass is the parameter ``payload``; the arm may carry 3 kg. Planners choose
    the joints' speeds, as users of the robot's own interface may do; torques within the limits
    follow them, and hold the arm against gravity.

    Source: Gaz, Cognetti, Oliva, Robuffo Giordano, De Luca, Dynamic identification of the Franka
    Emika Panda robot with retrieval of feasible parameters using penalty-based optimization, IEEE
    RA-L 4(4), 2019 (masses and inertias, as the manufacturer's robot description has them); Franka
    Control Interface documentation, Robot and interface specifications (sizes and limits).
    """
    q = [angle(f"q{k + 1}", low, high, speed=v) for k, (low, high, v, _) in enumerate(JOINTS)]
    before = (
        move(0, 0, 0.333),
        rot_x(-pi / 2),
        move(0, -0.316, 0) @ rot_x(pi / 2),
        move(0.0825, 0, 0) @ rot_x(pi / 2),
        move(-0.0825, 0.384, 0) @ rot_x(-pi / 2),
        rot_x(pi / 2),
        move(0.088, 0, 0) @ rot_x(pi / 2),
    )
    frames: list[Frame] = []
    for joint, coordinate in zip(before, q, strict=True):
        frames.append((frames[-1] if frames else WORLD) @ joint @ rot_z(coordinate))
    links = [
        part
        for k, (frame, (mass, centre, inertia), shapes) in enumerate(
            zip(frames, LINKS, SHAPES, strict=True)
        )
        for part in (
            Body(f"link {k + 1}", frame, shape=shapes, color=WHITE),
            Body(f"link {k + 1} mass", frame @ move(*centre), mass=mass, inertia=inertia),
        )
    ]
    flange = frames[-1] @ move(0, 0, 0.107) @ rot_z(-pi / 4)
    masses = links[1::2]
    base = Body("base", WORLD, shape=BASE, touches_ground=True, color=WHITE)
    bodies = [_can(flange), *_hand(flange), *links, base]
    g = parameter("g", 9.81, "m/s^2")
    set_points = [
        Reference(f"{c.name}_set", limit=v, unit="rad/s")
        for c, (_, _, v, _) in zip(q, JOINTS, strict=True)
    ]
    # 10.0 [1/s] with which joints take on the speeds that are asked for
    wanted = [10.0 * (r.symbol - rate(c)) for r, c in zip(set_points, q, strict=True)]
    torques = _torques(frames, [b for b in bodies if b.mass != 0], wanted, g)
    law = {f"tau{k + 1}": torque for k, torque in enumerate(torques)}
    return System(
        "panda",
        bodies=bodies,
        gravity=toward("-z", g),
        feedback=Feedback(set_points, law),
        inputs=[
            Torque(
                f"tau{k + 1}",
                on=masses[k],
                about=frames[k].z,
                limit=JOINTS[k][3],
                reacts_on=masses[k - 1] if k else None,
            )
            for k in range(len(JOINTS))
        ],
        collisions=[
            *((carried, f"link {k}") for carried in ("can", "hand") for k in (1, 2, 3, 4, 5)),
            *(("base", part) for part in ("can", "hand", "link 5", "link 6", "link 7")),
            *((f"link {k}", f"link {k + 4}") for k in (1, 2, 3)),
        ],
    )


def _torques(
    frames: Sequence[Frame], bodies: Sequence[Body], accelerations: Sequence[Expr], g: Expr
) -> list[Expr]:
    """Return the torques that accelerate the joints at rest, and hold them against gravity.

    Source: Lynch, Park, Modern Robotics, 2017, sections 8.3 (Newton-Euler) and 11.4.
    """
    poses = [homogeneous(frame) for frame in frames]
    axes, places = [pose[:3, 2] for pose in poses], [pose[:3, 3] for pose in poses]
    torques = [Integer(0)] * len(frames)
    for body in bodies:
        moved = _joints_below(body, frames)
        pose = homogeneous(body.frame)
        turn, centre = pose[:3, :3], pose[:3, 3]
        spin, push = zeros(3, 1), Matrix([0, 0, g])
        for k in moved:
            spin += axes[k] * accelerations[k]
            push += axes[k].cross(centre - places[k]) * accelerations[k]
        force, moment = body.mass * push, turn * body.inertia_matrix * turn.T * spin
        for k in moved:
            torques[k] += axes[k].dot(moment + (centre - places[k]).cross(force))
    return torques


def _joints_below(body: Body, frames: Sequence[Frame]) -> range:
    """Return which joints move a body: those whose motions its frame begins with."""
    motions = body.frame.motions
    own = [k for k, frame in enumerate(frames) if motions[: len(frame.motions)] == frame.motions]
    return range(max(own) + 1)


def _can(flange: Frame) -> Body:
    """Return what the fingers hold; its axis is x."""
    m, radius, height = parameter("payload", 1.0, "kg"), 0.033, 0.12
    across, along = m * (3 * radius**2 + height**2) / 12, m * radius**2 / 2
    return Body(
        "can",
        # 0.1034 [m] from the hand's flange to between the finger tips
        flange @ move(0, 0, 0.1034) @ rot_y(PITCH),
        mass=m,
        inertia=(along, across, across),
        shape=Cylinder(radius, height, axis="x"),
        color=RED,
    )


def _hand(flange: Frame) -> list[Body]:
    mass, centre, inertia = HAND
    fingers = (Box(0.02, 0.02, 0.06, at=(0, side * 0.043, 0.085)) for side in (1, -1))
    return [
        Body("hand", flange, shape=[Box(0.066, 0.21, 0.094, at=(0, 0, 0.02)), *fingers],
             color=DARK),
        Body("hand mass", flange @ move(*centre), mass=mass, inertia=inertia),
    ]  # fmt: skip
