"""The point-mass pendulum on a massless rod, solved by hand and by a second engine.

State x = (theta, theta_dot); theta = 0 hangs, counted about the pivot.  Input u = (torque,).  SI.

Sources:
    Landau, Lifshitz, Mechanics, 3rd ed., section 11, problem 1: the period by K(sin(theta0 / 2)).
    NIST Digital Library of Mathematical Functions, 22.19(i): the swing by Jacobi's functions.
    Arguments of elliptic functions are SciPy's parameter m = k^2.
    Pontryagin, Boltyanskii, Gamkrelidze, Mishchenko, The Mathematical Theory of Optimal Processes,
        1962, chapter 1: every fastest motion is driven by the sign of its costate.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
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


def energy_time(energy: float, limit: float, pendulum: Pendulum) -> float:
    """Return a lower bound in [s] for gaining an energy from rest at the bottom.

    dE/dt <= limit |theta_dot| and |theta_dot| <= sqrt(2 E / (m l^2)), since V >= 0; so sqrt(E)
    grows by at most limit / sqrt(2 m l^2) per second.

    Args:
        energy: At the end, in [J] above hanging at rest.
        limit: Largest torque in [N m].
    """
    return float(np.sqrt(2 * pendulum.inertia * energy)) / limit


@dataclass(frozen=True)
class SwingUp:
    """From rest at the bottom into a box about upright, with a limited torque.

    Attributes:
        limit: Largest torque in [N m].
        angle: Half width of the box in [rad].
        rate: Half height of the box in [rad/s].
    """

    limit: float
    angle: float
    rate: float
    pendulum: Pendulum = Pendulum()

    def reached(self, x: Array) -> NDArray[np.bool_]:
        """Whether states, shape (2, ...), lie in the box."""
        off = np.abs(np.remainder(x[0], 2 * np.pi) - np.pi)
        return np.asarray((off <= self.angle) & (np.abs(x[1]) <= self.rate))

    def slope(self, z: Array, u: Any) -> Array:
        """Return the derivative of state and costate z, shape (4, ...).

        H = a theta_dot + b (u - m g l sin theta) / (m l^2): a_dot = b m g l cos(theta) / (m l^2)
        and b_dot = -a.
        """
        theta, rate, a, b = z
        share = self.pendulum.weight_moment / self.pendulum.inertia
        turning = u / self.pendulum.inertia - share * np.sin(theta)
        return np.stack([rate, turning, b * share * np.cos(theta), -a])


def fastest_swing_up(task: SwingUp) -> tuple[float, float]:
    """Return the least time in [s] and the first costate's direction in [rad].

    By Pontryagin's principle a fastest motion has u = limit sign(b) for a costate (a, b) that is
    nowhere zero; b vanishes at single moments only, as a would vanish with it. So the motions from
    rest by all directions of the first costate contain it: one number to search. They come in
    mirrored pairs; half a circle is enough. The first step inside is sharp to 1e-3 s.
    """
    low, high, found = 0.0, np.pi, (np.inf, 0.0)
    for dt, count in ((5e-3, 1001), (1e-3, 41), (1e-3, 41)):
        directions = np.linspace(low, high, count)
        times = _times_of_entry(task, directions, dt, found[0])
        best = int(np.argmin(times))
        found, apart = (float(times[best]), float(directions[best])), directions[1] - directions[0]
        low, high = found[1] - 4 * apart, found[1] + 4 * apart
    return found


def _times_of_entry(task: SwingUp, directions: Array, dt: float, until: float) -> Array:
    """Return when each motion is first found inside, to ``dt``; inf if not by about ``until``."""
    rest = np.zeros((2, len(directions)))
    z = np.concatenate([rest, [np.cos(directions), np.sin(directions)]])
    times = np.full(len(directions), np.inf)
    for k in range(1, int(min(until + 0.05, 6.0) / dt) + 1):
        z = _bang_bang_step(task, z, dt)
        times[task.reached(z[:2]) & np.isinf(times)] = k * dt
        if k * dt > times.min() + 0.1:
            break
    return times


def _bang_bang_step(task: SwingUp, z: Array, dt: float) -> Array:
    """Advance by ``dt``, with the switch where the costate, taken as linear, changes its sign."""
    sign = np.where(z[3] == 0, -np.sign(z[2]), np.sign(z[3]))
    ahead = _runge_kutta(task, z, task.limit * sign, np.full(z.shape[1], dt))
    switches = sign * ahead[3] < 0
    before = np.where(switches, dt * z[3] / np.where(switches, z[3] - ahead[3], 1), dt)
    middle = _runge_kutta(task, z, task.limit * sign, before)
    return _runge_kutta(task, middle, -task.limit * sign, dt - before)


def _runge_kutta(task: SwingUp, z: Array, u: Array, h: Array) -> Array:
    one = task.slope(z, u)
    two = task.slope(z + h / 2 * one, u)
    three = task.slope(z + h / 2 * two, u)
    four = task.slope(z + h * three, u)
    return np.asarray(z + h / 6 * (one + 2 * two + 2 * three + four))


def switching_times(task: SwingUp, direction: float, until: float) -> tuple[float, Array]:
    """Return the first torque in [N m] and when it changes its sign, for one first costate."""
    z, t, switches = np.array([0, 0, np.cos(direction), np.sin(direction)]), 0.0, []
    u = first = task.limit * float(np.sign(z[3]))

    def costate(_: float, at: Array) -> float:
        return float(at[3])

    costate.terminal = True  # type: ignore[attr-defined]
    while t < until:
        costate.direction = -np.sign(u)  # type: ignore[attr-defined]
        run = solve_ivp(
            lambda _, at, u=u: task.slope(at, u),
            (t, until),
            z,
            "DOP853",
            events=costate,
            rtol=1e-11,
            atol=1e-12,
        )
        t, z, u = float(run.t[-1]), run.y[:, -1], -u
        switches.append(t)
    return first, np.array(switches[:-1])


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
