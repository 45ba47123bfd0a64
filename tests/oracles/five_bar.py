"""A parallel robot of five equal bars, by plane geometry and Lagrange's equation in two angles.

Nothing of kinolab is used: the elbows follow from the motors, the tool is where two circles meet,
and derivatives are differences, exact to about eight digits.

Source: Campos, Bourbonnais, Bonev, Bigras, Development of a five-bar parallel robot with large
workspace, ASME IDETC 2010, section 2 (direct kinematics).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NUDGE = 1e-4  # [rad] of central differences: their error is its square


@dataclass(frozen=True)
class FiveBar:
    """Length of a bar in [m]; masses of upper arms, forearms and tool in [kg]."""

    l: float = 0.25  # noqa: E741
    m_u: float = 0.3
    m_f: float = 0.15
    m_t: float = 0.1

    def elbows(self, a: Array) -> tuple[complex, complex]:
        """Where the elbows are, y being imaginary, for the motors' angles (a_l, a_r)."""
        left, right = (self.l * 1j * np.exp(1j * angle) for angle in a)
        return complex(left - self.l / 2), complex(right + self.l / 2)

    def tool(self, a: Array) -> complex:
        """Where the forearms meet: on the far side of the line from elbow to elbow."""
        left, right = self.elbows(a)
        half = (right - left) / 2
        ahead = 1j * half / abs(half)
        return left + half + ahead * float(np.sqrt(self.l**2 - abs(half) ** 2))

    def angles(self, a: Array) -> Array:
        """The configuration (a_l, a_r, f_l, f_r), the forearms' angles against home."""
        left, right = self.elbows(a)
        tip = self.tool(a)
        home = np.exp(1j * np.pi / 3), np.exp(2j * np.pi / 3)
        fore = [np.angle((tip - e) / h) for e, h in zip((left, right), home, strict=True)]
        return np.array([*a, *fore])

    def slopes(self, a: Array) -> Array:
        """How (a_l, a_r, f_l, f_r) follow from the motors' angles, shape (4, 2)."""
        steps = NUDGE * np.eye(2)
        return np.array([(self.angles(a + s) - self.angles(a - s)) / (2 * NUDGE) for s in steps]).T

    def mass_matrix(self, a: Array) -> Array:
        """M of T = a_dot M a_dot / 2: rods turn about their joints, forearms are also carried."""
        total = 2 * self.m_u * self.l**2 / 3 * np.eye(2) / 2
        turn = self.slopes(a)[2:]
        for k in (0, 1):
            middle, spin = self._velocity(a, k, 0.5), turn[k]
            total = total + self.m_f * (middle.T @ middle)
            total = total + self.m_f * self.l**2 / 12 * np.outer(spin, spin)
        tip = self._velocity(a, 0, 1.0)
        about = self.m_t * 0.01**2 / 2  # the tool turns with the left forearm
        return np.asarray(total + self.m_t * (tip.T @ tip) + about * np.outer(turn[0], turn[0]))

    def _velocity(self, a: Array, arm: int, share: float) -> Array:
        """How a point along a forearm moves with the motors' angles, shape (2, 2)."""

        def place(at: Array) -> Array:
            point = (1 - share) * self.elbows(at)[arm] + share * self.tool(at)
            return np.array([point.real, point.imag])

        steps = NUDGE * np.eye(2)
        return np.array([(place(a + s) - place(a - s)) / (2 * NUDGE) for s in steps]).T

    def accelerations(self, a: Array, rates: Array, torques: Array) -> Array:
        """d/dt (M a_dot) - dT/da = torques, with the derivatives of M as differences."""
        slope = np.array(
            [
                (self.mass_matrix(a + step) - self.mass_matrix(a - step)) / (2 * NUDGE)
                for step in NUDGE * np.eye(2)
            ]
        )
        change = np.einsum("kij,k->ij", slope, rates) @ rates
        pull = np.einsum("kij,i,j->k", slope, rates, rates) / 2
        return np.asarray(np.linalg.solve(self.mass_matrix(a), torques - change + pull))
