"""Koo and Sastry's helicopter in the axes of the paper, and its trim in hover.

Body axes here: x ahead, y to the right, z down, and a world with z down. kinolab's point to the
left and up, so that vectors change the signs of y and z: ``to_up`` turns one into the other.
Inputs u = (thrust, tail, tilt back, tilt right) in [N], [N], [rad], [rad].

Source: Koo, Sastry, Output tracking control design of a helicopter model based on approximate
linearization, CDC 1998, equations (3) to (8), without the tail rotor's own torque.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root
from scipy.spatial.transform import Rotation

Array: TypeAlias = NDArray[np.float64]
Values: TypeAlias = Mapping[str, float]

FLIP = np.array([1.0, -1.0, -1.0])


def to_up(vector: Array) -> Array:
    """Components along axes that point ahead, left and up."""
    return FLIP * vector


def wrench(u: Array, p: Values) -> Array:
    """Force and moment of both rotors about the centre of mass, shape (6,), z down."""
    T, T_t, a, b = u
    Q = p["C"] * T**1.5 + p["D"]
    X, Y, Z = -T * np.sin(a), T * np.sin(b), -T * np.cos(a) * np.cos(b)
    Y_t = -T_t
    roll = p["K"] * b - Q * np.sin(a) + Y * p["h"] + Y_t * p["h_t"]
    pitch = p["K"] * a + Q * np.sin(b) - X * p["h"]
    yaw = -Q * np.cos(a) * np.cos(b) - Y_t * p["l_t"]
    return np.array([X, Y + Y_t, Z, roll, pitch, yaw])


def accelerations(attitude: Rotation, rates: Array, u: Array, p: Values) -> Array:
    """World acceleration and derivative of the body's rates, shape (6,), axes ahead, left, up."""
    load = wrench(u, p)
    force, moment = to_up(load[:3]), to_up(load[3:])
    I = np.array([p["Ixx"], p["Iyy"], p["Izz"]])  # noqa: E741
    fall = np.array([0.0, 0.0, -p["g"]])
    spin = (moment - np.cross(rates, I * rates)) / I
    return np.append(attitude.apply(force) / p["m"] + fall, spin)


class Trim(NamedTuple):
    """Hover: what holds the helicopter where it is."""

    u: Array  # (4,)
    roll: float  # [rad] to the right
    pitch: float  # [rad] nose up

    @property
    def attitude(self) -> Rotation:
        """From axes ahead, left and up in the body to those of the world."""
        down = Rotation.from_euler("YX", [self.pitch, self.roll]).as_matrix()
        return Rotation.from_matrix(FLIP[:, None] * down * FLIP)


def hover(p: Values) -> Trim:
    """Solve the six equations of force and moment for the inputs, roll and pitch."""
    weight = p["m"] * p["g"]

    def unbalanced(z: Array) -> Array:
        T, T_t, a, b, roll, pitch = z * [weight, 1.0, 1.0, 1.0, 1.0, 1.0]
        load = wrench(np.array([T, T_t, a, b]), p)
        gravity = [-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)]
        load[:3] += weight * np.array(gravity)
        return load / weight

    found = root(unbalanced, [1.0, 4.0, 0.0, 0.0, 0.05, 0.0], tol=1e-15, method="hybr")
    z = found.x
    if np.abs(unbalanced(z)).max() > 1e-14:
        raise ArithmeticError(found.message)
    return Trim(np.array([weight * z[0], *z[1:4]]), float(z[4]), float(z[5]))
