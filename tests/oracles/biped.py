"""A planar biped whose stance foot is pinned to the ground, kinematics by complex numbers.

SI units; the plane is x ahead and z up, a point is x + i z. Configuration:
q = (x, z, theta, hip_l, knee_l, hip_r, knee_r), torso first, joints at zero where the legs hang in
line with the torso. With ``sense = 1`` angles grow from x to z (a leg swings ahead, the torso leans
back); with ``sense = -1`` they grow the other way, as right-handed turns about y do.

foot = x + i z - i (h e^{i s theta} + L_1 e^{i s (theta + hip)} + L_2 e^{i s (theta + hip + knee)})

A ``point`` foot stays where it is and lets the shank turn: 2 rows of w q_dot = 0, and
u = (theta_dot, four joint rates). A ``flat`` foot is one with its shank: 3 rows, u = joint rates.

Sources:
    Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, chapter 7: what
        is allowed by w q_dot = 0 is spanned by the columns of S, q_dot = S(q) u.
    Westervelt, Grizzle, Chevallereau, Choi, Morris, Feedback Control of Dynamic Bipedal Robot
        Locomotion, 2007, chapter 3: stance and swing leg, and their relabelling.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
Side = Literal["left", "right"]
Foot = Literal["point", "flat"]

COORDINATES = ("x", "z", "theta", "hip_l", "knee_l", "hip_r", "knee_r")
HIP = {"left": 3, "right": 5}  # where a leg's two joints begin
OTHER: dict[Side, Side] = {"left": "right", "right": "left"}


@dataclass(frozen=True)
class Biped:
    """Lengths in [m].

    Attributes:
        h: Both hips below the torso's origin, along the torso.
        L_1: Thigh.
        L_2: Shank, to the sole.
        sense: 1 where angles grow from x to z, -1 where from z to x.
    """

    h: float = 0.3
    L_1: float = 0.45
    L_2: float = 0.45
    sense: int = 1


def links(q: Array, side: Side, robot: Biped) -> Array:
    """Return torso, thigh and shank of one leg as complex vectors in [m], shape (3,), downwards."""
    angles = np.cumsum([q[2], q[HIP[side]], q[HIP[side] + 1]])
    lengths = np.array([robot.h, robot.L_1, robot.L_2])
    return np.asarray(-1j * lengths * np.exp(1j * robot.sense * angles))


def leg_points(q: Array, side: Side, robot: Biped) -> Array:
    """Return where hip, knee and foot of one leg are in [m], shape (3, 2)."""
    places = complex(q[0], q[1]) + np.cumsum(links(q, side, robot))
    return np.stack([places.real, places.imag], axis=1)


def foot_place(q: Array, side: Side, robot: Biped) -> Array:
    """Return where a foot is in [m], shape (2,)."""
    return np.asarray(leg_points(q, side, robot)[2])


def shank_angle(q: Array, side: Side) -> float:
    """Return the angle of a shank from hanging straight down in [rad]."""
    return float(q[2] + q[HIP[side]] + q[HIP[side] + 1])


# Stance


def foot_jacobian(q: Array, side: Side, robot: Biped) -> Array:
    """Return d foot / d q, shape (2, 7): an angle turns what hangs below its joint."""
    below = links(q, side, robot)[::-1].cumsum()[::-1]
    turned = 1j * robot.sense * below
    J = np.zeros((2, 7))
    J[:, :2] = np.eye(2)
    J[:, [2, HIP[side], HIP[side] + 1]] = [turned.real, turned.imag]
    return J


def stance_rows(q: Array, side: Side, robot: Biped, foot: Foot = "point") -> Array:
    """Return w of w q_dot = 0, shape (2, 7) for a point foot and (3, 7) for a flat one."""
    J = foot_jacobian(q, side, robot)
    if foot == "point":
        return J
    shank = np.zeros((1, 7))
    shank[0, [2, HIP[side], HIP[side] + 1]] = 1
    return np.vstack([J, shank])


def stance_rates(q: Array, u: Array, side: Side, robot: Biped, foot: Foot = "point") -> Array:
    """Return q_dot, shape (7,), while one foot is pinned.

    Args:
        u: (theta_dot, hip_l, knee_l, hip_r, knee_r rates) for a point foot, shape (5,); without
            theta_dot for a flat one, shape (4,).
    """
    first = HIP[side] - 3
    turn, joints = (u[0], u[1:]) if foot == "point" else (-(u[first] + u[first + 1]), u)
    turns = np.cumsum([turn, joints[first], joints[first + 1]])
    torso = -(1j * robot.sense * turns * links(q, side, robot)).sum()
    return np.array([torso.real, torso.imag, turn, *joints])


def stance_basis(q: Array, side: Side, robot: Biped, foot: Foot = "point") -> Array:
    """Return S of q_dot = S(q) u, shape (7, 5) for a point foot and (7, 4) for a flat one."""
    inputs = 5 if foot == "point" else 4
    return np.array([stance_rates(q, e, side, robot, foot) for e in np.eye(inputs)]).T


def double_basis(q: Array, robot: Biped) -> Array:
    """Return what moves neither of two point feet: orthonormal columns, shape (7, 3).

    The four rows are independent unless both legs are straight and parallel.
    """
    rows = np.vstack([foot_jacobian(q, side, robot) for side in OTHER])
    return np.asarray(np.linalg.svd(rows)[2][4:].T)


# From one stance to the other


def from_stance(place: Array, angles: Array, side: Side, robot: Biped) -> Array:
    """Return q, shape (7,), of a foot's place, shape (2,), and (theta, joints), shape (5,)."""
    hanging = np.array([0.0, 0.0, *angles])
    return np.array([*(place - foot_place(hanging, side, robot)), *angles])


def other_foot(place: Array, angles: Array, side: Side, robot: Biped) -> Array:
    """Return where the other foot is, shape (2,): as the stance changes, the angles stay."""
    return foot_place(from_stance(place, angles, side, robot), OTHER[side], robot)


def torso_jump(q: Array, u: Array, robot: Biped) -> Array:
    """Return by how much the torso's (x_dot, z_dot) jumps, shape (2,), from left to right stance.

    The same u = (theta_dot, joint rates) before and after: the torso loses the velocity that the
    landing foot had.
    """
    before, after = (stance_rates(q, u, side, robot)[:2] for side in ("left", "right"))
    return np.asarray(after - before)


def walk(q: Array, moves: list[tuple[Side, Array]], robot: Biped) -> list[Array]:
    """Return the configurations after each move, the first one included, exactly.

    Args:
        moves: Which foot is pinned, and by how much (theta, joints) change meanwhile, shape (5,).
    """
    path = [np.asarray(q, dtype=np.float64)]
    for side, change in moves:
        place = foot_place(path[-1], side, robot)
        path.append(from_stance(place, path[-1][2:] + change, side, robot))
    return path


def reach(hip: Array, foot: Array, theta: float, bend: int, robot: Biped) -> Array:
    """Return (hip, knee) in [rad], shape (2,), that bring a foot from its hip to a place.

    Law of cosines in the triangle of thigh, shank and their span.

    Args:
        hip: Where the hip is in [m], shape (2,).
        foot: Where the foot shall be in [m], shape (2,).
        theta: Torso in [rad].
        bend: Sign of the knee's angle.

    Raises:
        ValueError: If the foot is out of reach.
    """
    span = complex(*(foot - hip))
    cosine = (abs(span) ** 2 - robot.L_1**2 - robot.L_2**2) / (2 * robot.L_1 * robot.L_2)
    if not -1 <= cosine <= 1:
        raise ValueError(f"the foot is {abs(span)} m from its hip")
    knee = bend * float(np.arccos(cosine))
    bent = -1j * (robot.L_1 + robot.L_2 * np.exp(1j * robot.sense * knee))
    thigh = robot.sense * float(np.angle(span / bent))
    turned = np.exp(1j * (thigh - theta))
    return np.array([float(np.angle(turned)), knee])


# What a pinned foot does along an integrated motion


def stance_motion(
    q: Array,
    u: Callable[[float], Array],
    duration: float,
    side: Side,
    robot: Biped,
    foot: Foot = "point",
    rtol: float = 1e-11,
) -> Array:
    """Return q at DOP853's own steps, shape (n, 7), from q_dot = S(q) u(t)."""
    run = solve_ivp(
        lambda t, q: stance_rates(q, u(t), side, robot, foot),
        (0, duration), q, "DOP853", rtol=rtol, atol=1e-12,
    )  # fmt: skip
    return np.asarray(run.y.T)


def drift(path: Array, side: Side, robot: Biped) -> float:
    """Return how far a foot strays from its first place in [m], over configurations (n, 7)."""
    places = np.array([foot_place(q, side, robot) for q in path])
    return float(np.linalg.norm(places - places[0], axis=1).max())
