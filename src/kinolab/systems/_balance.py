"""Balance controllers of a one-wheeled robot: roll by a reaction wheel, pitch by its drive.

Each places the poles of a planar mechanism with small angles, in one plane of the machine. What
this neglects is in the planner's model, and is corrected by feedback along the plan.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from kinolab.dynamics import rate

TIPPING = 6.0  # [1/s] bandwidth of the lean, critically damped
PITCHING, ROLLING = 9.0, 1.0  # [1/s] poles of the pitch (double) and of the speed


@dataclass(frozen=True)
class Aside:
    """Roll plane, a reaction wheel on a pendulum: inertia theta_ddot = moment - torque.

    Attributes:
        inertia: Moment of inertia about the line that the machine rolls along.
        moment: Of weight and gyroscopic effects about this line.
    """

    inertia: sympy.Expr
    moment: sympy.Expr

    def torque(self, theta: sympy.Expr, lean: sympy.Expr) -> sympy.Expr:
        """Return the torque by which theta follows a lean with two poles at -TIPPING."""
        wanted = TIPPING**2 * (lean - theta) - 2 * TIPPING * rate(theta)
        return self.moment - self.inertia * wanted


@dataclass(frozen=True)
class Ahead:
    """Pitch plane, a pendulum on a wheel that drives against it, at spin s and pitch alpha.

    rolling s_dot + coupling alpha_ddot = torque
    coupling s_dot + tilting alpha_ddot = weight alpha - torque

    Attributes:
        rolling: Moment of inertia of all that rolls, about the contact point.
        coupling: First moment of the pendulum about the axle, times the wheel's radius.
        tilting: Moment of inertia of the pendulum about the axle.
        weight: First moment of the pendulum, times gravity.
    """

    rolling: sympy.Expr
    coupling: sympy.Expr
    tilting: sympy.Expr
    weight: sympy.Expr

    def torque(self, alpha: sympy.Expr, excess: sympy.Expr) -> sympy.Expr:
        """Return the torque that drives the spin error to zero, poles -PITCHING (double), -ROLLING.

        With the pitch's acceleration a = -(k_1 alpha + k_2 alpha_dot + k_3 excess) as the input,
        the sum of both equations is s_dot = p alpha - q a, so that the poles are the roots of
        z^3 + (k_2 - q k_3) z^2 + k_1 z + p k_3.
        """
        whole = self.rolling + self.coupling
        p, q = self.weight / whole, (self.tilting + self.coupling) / whole
        k_1 = PITCHING**2 + 2 * PITCHING * ROLLING
        k_3 = PITCHING**2 * ROLLING / p
        k_2 = 2 * PITCHING + ROLLING + q * k_3
        a = -(k_1 * alpha + k_2 * rate(alpha) + k_3 * excess)
        determinant = self.rolling * self.tilting - self.coupling**2
        return (self.rolling * self.weight * alpha - determinant * a) / whole
