"""The coin that may fall over, solved by hand.

State x = (x, y, psi, theta, phi, psi_dot, theta_dot, phi_dot): contact point, heading, lean (to the
right), roll. Inputs u = (drive, steer): torque about the axle, torque about the line k from the
contact to the centre. SI units throughout.

In the axes (heading i, axle j to the left, k), which turn at W = (theta_dot, p, w3) with
p = psi_dot sin(theta), the disk turns at

    w = (theta_dot, phi_dot + p, psi_dot cos(theta)).

Rolling gives the centre the velocity w x R k = R (w2, -w1, 0), so the acceleration

    a = R (w2' + w1 w3, -w1' + w2 w3, -w1^2 - p w2).

The contact's force F = m (a + g (0, sin(theta), cos(theta))) has the moment
-R k x F = R (F2, -F1, 0) about the centre. With H = (B w1, A w2, B w3), Euler's
H' + W x H = moment + (0, drive, steer) reads

    (B + m R^2) w1' = (A + m R^2) w2 w3 - B p w3 + m g R sin(theta),
    (A + m R^2) w2' = -m R^2 w1 w3 + drive,
    B w3' = B p w1 - A w1 w2 + steer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FallingDisk:
    """A round body of mass ``m`` in [kg] and radius ``R`` in [m] in the field ``g`` in [m/s^2].

    Attributes:
        A: Moment about the axle in [kg m^2].
        B: Moment about a diameter in [kg m^2].
    """

    m: float = 1.0
    R: float = 0.3
    g: float = 9.81
    A: float = 0.045
    B: float = 0.0225

    @property
    def rolling(self) -> float:
        """Moment about the contact along the axle in [kg m^2]."""
        return self.A + self.m * self.R**2


def accelerations(x: Array, u: Array, disk: FallingDisk) -> Array:
    """Return (psi_ddot, theta_ddot, phi_ddot), shape (..., 3), for states of shape (..., 8)."""
    theta, turn, leaning, roll = x[..., 3], x[..., 5], x[..., 6], x[..., 7]
    sin, cos = np.sin(theta), np.cos(theta)
    p, w1, w2, w3 = turn * sin, leaning, roll + turn * sin, turn * cos
    weight, swing = disk.m * disk.g * disk.R * sin, disk.m * disk.R**2
    w1_dot = (disk.rolling * w2 * w3 - disk.B * p * w3 + weight) / (disk.B + swing)
    w2_dot = (u[..., 0] - swing * w1 * w3) / disk.rolling
    w3_dot = p * w1 - disk.A / disk.B * w1 * w2 + u[..., 1] / disk.B
    psi_ddot = (w3_dot + turn * leaning * sin) / cos
    phi_ddot = w2_dot - psi_ddot * sin - turn * leaning * cos
    return np.stack([psi_ddot, w1_dot, phi_ddot], axis=-1)


def steady_spin(lean: float, turn: float, disk: FallingDisk) -> float:
    """Spin in [rad/s] of the steady circle with this lean in [rad] and yaw rate in [rad/s]."""
    rest = (disk.rolling - disk.B) * turn**2 * np.sin(lean) * np.cos(lean)
    weight = disk.m * disk.g * disk.R * np.sin(lean)
    return float(-(rest + weight) / (disk.rolling * turn * np.cos(lean)))


def growth(spin: float, disk: FallingDisk) -> float:
    """Return the squared rate in [1/s^2] at which a lean grows near straight rolling."""
    gyroscope = disk.A * disk.rolling * spin**2 / disk.B
    return float((disk.m * disk.g * disk.R - gyroscope) / (disk.B + disk.m * disk.R**2))
