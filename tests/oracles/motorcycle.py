"""The motorcycle of Getz and Marsden, by hand.

State x = (x, y, psi, alpha, delta, phi, alpha_dot, delta_dot, phi_dot): rear contact, heading, lean
(to the right), steering angle (to the left), rotation of the rear wheel. Inputs u = (drive, steer):
torque on the rear wheel, acceleration of the steering angle. SI units throughout.

The mass is c ahead of the rear contact and p above it in the leaning plane. With v = R phi_dot,
sigma = tan(delta) / b and psi_dot = sigma v its velocity ahead, to the left and up is

    (v (1 + p sigma sin(alpha)), c sigma v - p alpha_dot cos(alpha), -p alpha_dot sin(alpha)).

Its acceleration, less gravity, does no work along the two motions that are free: v alone moves it
along (1 + p sigma sin(alpha), c sigma, 0), alpha alone along -p (0, cos(alpha), sin(alpha)). The
drive's force is the torque over R.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

Array = NDArray[np.float64]

STATES = ("x", "y", "psi", "alpha", "delta", "phi", "alpha_dot", "delta_dot", "phi_dot")


@dataclass(frozen=True)
class Motorcycle:
    """A mass ``m`` in [kg] at height ``p``, ``c`` ahead; wheelbase ``b``, wheels ``R``, in [m]."""

    m: float = 200.0
    p: float = 0.65
    c: float = 0.7
    b: float = 1.4
    R: float = 0.3
    g: float = 9.81


def state_derivative(x: Array, u: Array, bike: Motorcycle) -> Array:
    """Return x_dot, shape (9,)."""
    psi, alpha, delta, _, alpha_dot, delta_dot, phi_dot = x[2:]
    m, p, c, R, g = bike.m, bike.p, bike.c, bike.R, bike.g
    sin, cos, v = np.sin(alpha), np.cos(alpha), R * phi_dot
    sigma, sigma_dot = np.tan(delta) / bike.b, delta_dot / (bike.b * np.cos(delta) ** 2)
    far = 1 + p * sigma * sin
    far_dot = p * (sigma_dot * sin + sigma * cos * alpha_dot)
    ahead, aside = v * far, c * sigma * v - p * alpha_dot * cos
    by_v, by_alpha = np.array([far, c * sigma, 0]), -p * np.array([0, cos, sin])
    # The acceleration is by_v v_dot + by_alpha alpha_ddot + rest.
    turning = sigma * v * np.array([-aside, ahead, 0])
    rest = turning + np.array(
        [v * far_dot, c * sigma_dot * v + p * alpha_dot**2 * sin, -p * alpha_dot**2 * cos]
    )
    force = -m * (rest + np.array([0, 0, g]))
    masses = m * np.array([[by_v @ by_v, by_v @ by_alpha], [by_v @ by_alpha, by_alpha @ by_alpha]])
    loads = [u[0] / R + by_v @ force, by_alpha @ force]
    v_dot, alpha_ddot = np.linalg.solve(masses, loads)
    place = [v * np.cos(psi), v * np.sin(psi), sigma * v]
    return np.array([*place, alpha_dot, delta_dot, phi_dot, alpha_ddot, u[1], v_dot / R])


def roll_residual(x: Array, x_dot: Array, bike: Motorcycle) -> float:
    """Left less right side of the published roll equation, in [m/s^2].

    p alpha_ddot = g sin a + (1 + p sigma sin a) sigma v^2 cos a + c cos a (v sigma)'.

    Source: Getz, Marsden, Control for an autonomous bicycle, ICRA 1995.
    """
    alpha, delta, delta_dot, phi_dot = x[3], x[4], x[7], x[8]
    sin, cos, v, v_dot = np.sin(alpha), np.cos(alpha), bike.R * phi_dot, bike.R * x_dot[8]
    sigma, sigma_dot = np.tan(delta) / bike.b, delta_dot / (bike.b * np.cos(delta) ** 2)
    turning = (1 + bike.p * sigma * sin) * sigma * v**2 * cos
    tilting = bike.c * cos * (v_dot * sigma + v * sigma_dot)
    return float(bike.p * x_dot[6] - bike.g * sin - turning - tilting)


def steady_lean(v: float, delta: float, bike: Motorcycle) -> float:
    """Lean in [rad] of the steady turn at speed v in [m/s] and steering angle delta in [rad]."""
    sigma = np.tan(delta) / bike.b

    def excess(alpha: float) -> float:
        share = (1 + bike.p * sigma * np.sin(alpha)) * sigma * v**2
        return float(bike.g * np.sin(alpha) + share * np.cos(alpha))

    return float(brentq(excess, -1.5, 1.5, xtol=1e-15, rtol=1e-15))
