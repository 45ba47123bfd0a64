"""The point-mass pendulum on a massless rod, solved by hand and by a second engine.

State x = (theta, theta_dot); theta = 0 hangs, counted about the pivot.  Input u = (torque,).  SI.

Sources:
    Landau, Lifshitz, Mechanics, 3rd ed., section 11, problem 1: the period by K(sin(theta0 / 2)).
    NIST Digital Library of Mathematical Functions, 22.19(i): the swing by Jacobi's functions.
    Arguments of elliptic functions are SciPy's parameter m = k^2.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from scipy.special import ellipj, ellipk
from sympy.physics.mechanics import (
    KanesMethod,
    LagrangesMethod,
    Particle,
    Point,
    ReferenceFrame,
    dynamicsymbols,
)

Array = NDArray[np.float64]
Acceleration = Callable[[Array, Array], float]  # (2,), (1,) -> theta_ddot in [rad/s^2]

TORQUE = sp.Symbol("torque")
STATES = ("theta", "theta_dot")
CONTROLS = ("torque",)


@dataclass(frozen=True)
class Pendulum:
    """Mass ``m`` in [kg] at distance ``l`` in [m] from the pivot, gravity ``g`` in [m/s^2]."""

    m: float = 1.0
    l: float = 1.0  # noqa: E741  the rod's length has this letter everywhere
    g: float = 9.81

    @property
    def inertia(self) -> float:
        """Moment of inertia about the pivot in [kg m^2]."""
        return self.m * self.l**2

    @property
    def weight_moment(self) -> float:
        """Torque of the weight when the rod is horizontal, in [N m]."""
        return self.m * self.g * self.l

    @property
    def small_frequency(self) -> float:
        """Angular frequency of small swings, sqrt(g / l), in [rad/s]."""
        return float(np.sqrt(self.g / self.l))


def state_derivative(x: Array, u: Array, pendulum: Pendulum) -> Array:
    """Closed form of x_dot, shape (..., 2): m l^2 theta_ddot = torque - m g l sin(theta)."""
    theta, rate = x[..., 0], x[..., 1]
    moment = u[..., 0] - pendulum.weight_moment * np.sin(theta)
    return np.stack(np.broadcast_arrays(rate, moment / pendulum.inertia), axis=-1)


def mass_matrix(pendulum: Pendulum) -> Array:
    """M, shape (1, 1), in [kg m^2]."""
    return np.array([[pendulum.inertia]])


def kinetic_energy(rate: float, pendulum: Pendulum) -> float:
    """T in [J]: half m times the squared speed of the mass on its circle."""
    return pendulum.m * (pendulum.l * rate) ** 2 / 2


def potential_energy(theta: float, pendulum: Pendulum) -> float:
    """V in [J] above the hanging position: weight times height."""
    return pendulum.m * pendulum.g * pendulum.l * (1.0 - float(np.cos(theta)))


def period(amplitude: float, pendulum: Pendulum) -> float:
    """Return the exact period in [s] of a swing with ``amplitude`` in (0, pi): 4 sqrt(l/g) K."""
    return 4.0 * float(ellipk(np.sin(amplitude / 2) ** 2)) / pendulum.small_frequency


def swing(amplitude: float, t: Array, pendulum: Pendulum) -> Array:
    """States at times ``t``, shape (len(t), 2), released at rest from ``amplitude``.

    sin(theta / 2) = k cd(w t), k = sin(amplitude / 2), w = sqrt(g / l).
    """
    k = np.sin(amplitude / 2)
    sn, cn, dn, _ = ellipj(pendulum.small_frequency * t, k**2)
    theta = 2 * np.arcsin(k * cn / dn)
    rate = -2 * k * np.cos(amplitude / 2) * pendulum.small_frequency * sn / dn
    return np.stack([theta, rate], axis=-1)


def lagrange_acceleration(pendulum: Pendulum) -> Acceleration:
    """theta_ddot by SymPy's LagrangesMethod, from the particle's speed and height."""
    theta = dynamicsymbols("theta")
    world, rod, bob, depth = _bob_in_space(theta, theta.diff(), pendulum)
    L = bob.kinetic_energy(world) + pendulum.m * pendulum.g * depth
    method = LagrangesMethod(L, [theta], forcelist=[(rod, TORQUE * world.z)], frame=world)
    method.form_lagranges_equations()
    return _solver(method.mass_matrix, method.forcing, theta, theta.diff())


def kane_acceleration(pendulum: Pendulum) -> Acceleration:
    """theta_ddot by SymPy's KanesMethod, with the weight as a force on the particle."""
    theta, rate = dynamicsymbols("theta rate")
    world, rod, bob, _ = _bob_in_space(theta, rate, pendulum)
    loads = [(rod, TORQUE * world.z), (bob.point, pendulum.m * pendulum.g * world.x)]
    method = KanesMethod(world, [theta], [rate], kd_eqs=[rate - theta.diff()])
    method.kanes_equations([bob], loads)
    return _solver(method.mass_matrix, method.forcing, theta, rate)


def _bob_in_space(theta: Any, rate: Any, pendulum: Pendulum) -> tuple[Any, Any, Any, Any]:
    """Return the inertial frame (x down), the rod's frame, the particle, its depth in [m]."""
    world, rod = ReferenceFrame("N"), ReferenceFrame("A")
    rod.orient_axis(world, world.z, theta)
    rod.set_ang_vel(world, rate * world.z)
    pivot, end = Point("O"), Point("P")
    pivot.set_vel(world, 0)
    end.set_pos(pivot, pendulum.l * rod.x)
    end.v2pt_theory(pivot, world, rod)
    return world, rod, Particle("bob", end, pendulum.m), end.pos_from(pivot).dot(world.x)


def _solver(mass: Any, forcing: Any, theta: Any, rate: Any) -> Acceleration:
    """Divide forcing by mass with numbers."""
    quotient = (forcing[0] / mass[0]).subs({rate: sp.Symbol("rate")})
    formula = sp.lambdify((theta, sp.Symbol("rate"), TORQUE), quotient)
    return lambda x, u: float(formula(*x, *u))
