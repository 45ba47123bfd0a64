"""Poses given by numbers, as the frames that machines are written with."""

from __future__ import annotations

import math

import numpy as np
import sympy

from kinolab.dynamics.language.frames import (
    WORLD,
    Frame,
    move,
    rot_x,
    rot_y,
    rot_z,
)
from kinolab.dynamics.language.shapes import AxisName
from kinolab.numerics.arrays import Array

EXACT_ANGLE = math.pi / 12  # [rad] whose multiples are taken as exact: 15 degrees
ROUNDING = 1e-12  # of angles in [rad], and of entries of rotation matrices
TURNS = {"x": rot_x, "y": rot_y, "z": rot_z}


def constant_frame(pose: Array) -> Frame:
    """Return a pose (4, 4) as a frame, with as few elementary rotations as it takes."""
    x, y, z = (float(entry) for entry in pose[:3, 3])
    frame = move(x, y, z) if x or y or z else WORLD
    for axis, angle in elementary_turns(pose[:3, :3]):
        frame = frame @ TURNS[axis](as_angle(angle))
    return frame


def as_angle(angle: float) -> sympy.Expr | float:
    """Return an angle in [rad], as a fraction of pi if it is one to rounding."""
    parts = round(angle / EXACT_ANGLE)
    return sympy.pi * parts / 12 if abs(angle - parts * EXACT_ANGLE) < ROUNDING else angle


def elementary_turns(turn: Array) -> list[tuple[AxisName, float]]:
    """Return the rotations about single axes whose product is a rotation matrix (3, 3)."""
    axes: tuple[AxisName, AxisName, AxisName] = ("x", "y", "z")
    for k, axis in enumerate(axes):
        i, j = (k + 1) % 3, (k + 2) % 3
        if turn[k, k] > 0.0 and max(abs(turn[k, i]), abs(turn[k, j])) < ROUNDING:
            angle = math.atan2(turn[j, i], turn[i, i])
            return [(axis, angle)] if abs(angle) > ROUNDING else []
    # R = Rz(yaw) Ry(pitch) Rx(roll)
    pitch = math.atan2(-turn[2, 0], math.hypot(turn[0, 0], turn[1, 0]))
    if math.hypot(turn[0, 0], turn[1, 0]) < ROUNDING:
        roll, yaw = math.atan2(-turn[1, 2], turn[1, 1]), 0.0
    else:
        roll = math.atan2(turn[2, 1], turn[2, 2])
        yaw = math.atan2(turn[1, 0], turn[0, 0])
    every: list[tuple[AxisName, float]] = [("z", yaw), ("y", pitch), ("x", roll)]
    return [(axis, angle) for axis, angle in every if abs(angle) > ROUNDING]


def along_an_axis(direction: Array) -> tuple[AxisName, float] | None:
    """Return the axis that a unit vector (3,) is along, and its sign; None if it is oblique."""
    k = int(np.abs(direction).argmax())
    rest = np.delete(direction, k)
    if np.abs(rest).max() > ROUNDING:
        return None
    axes: tuple[AxisName, AxisName, AxisName] = ("x", "y", "z")
    return axes[k], math.copysign(1.0, direction[k])


def onto_z(direction: Array) -> Array:
    """Return a rotation matrix (3, 3) that takes the z axis to a unit vector (3,)."""
    x, y, z = direction
    across = math.hypot(x, y)
    cos, sin = (x / across, y / across) if across > 0.0 else (1.0, 0.0)
    return np.array([[cos * z, -sin, x], [sin * z, cos, y], [-across, 0.0, z]])


def shortest_onto_z(direction: Array) -> Array:
    """Return the smallest rotation (3, 3) that takes the z axis to a unit vector (3,).

    Onto -z it turns about x. What it makes of x and y spans the plane of a planar joint, as
    MuJoCo has it: URDF says only what that is across.
    """
    across = np.array([-direction[1], direction[0], 0.0])
    sine = float(np.linalg.norm(across))
    axis = across / sine if sine > 0.0 else np.array([1.0, 0.0, 0.0])
    return turned_about(axis, math.atan2(sine, direction[2]))


def turned_about(axis: Array, at: float) -> Array:
    """Return the rotation matrix (3, 3) about a unit vector (3,) by an angle in [rad].

    Source: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, (2.14).
    """
    x, y, z = axis
    hat = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn: Array = np.eye(3) + math.sin(at) * hat + (1.0 - math.cos(at)) * hat @ hat
    return turn
