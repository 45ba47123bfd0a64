"""Two walkers without motors that step down a slope, by hand: swing phases, heelstrikes, gaits.

The frame lies in the slope: x down along it, z normal to it, angles counter-clockwise in [rad].
theta is the stance leg's angle from the normal, positive where the leg leans uphill, so that
hip = foot + l (-sin theta, cos theta). The swing leg hangs from the hip at psi = theta - phi:
its foot is at hip + l (sin psi, -cos psi). ``gamma`` is the slope. A walker of rigid straight legs
scuffs the ground as its legs pass each other (phi = 0), which both models overlook; the heel
strikes at phi = 2 theta with theta < 0.

Simplest walker: state (theta, phi, theta_dot, phi_dot), time in sqrt(l / g); all mass at the hip
but for feet that are too light to disturb it.
Compass: state (theta, psi, theta_dot, psi_dot), SI units; a hip and two legs with point masses.

Sources:
    Garcia, Chatterjee, Ruina, Coleman, The simplest walking model: stability, complexity, and
        scaling, J. Biomechanical Engineering 120(2), 1998: equations, heelstrike, gaits.
    Goswami, Thuilot, Espiau, A study of the passive gait of a compass-like biped robot, IJRR
        17(12), 1998: what is conserved as a heel strikes.
    Spong, Bullo, Controlled symmetries and passive walking, IEEE TAC 50(7), 2005: the slope only
        tilts gravity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp
from scipy.optimize import fsolve

Array = NDArray[np.float64]
Rate = Callable[[Array], Array]

# (theta, theta_dot) after a heelstrike at gamma = 0.009, as published; the long gait is stable
LONG_GAIT = np.array([0.2003109, -0.1998325])
SHORT_GAIT = np.array([0.1939374, -0.2038669])

PATIENCE = 20.0  # a swing that takes this many times sqrt(l / g) has fallen


@dataclass(frozen=True)
class Swing:
    """What happened between two heelstrikes.

    Attributes:
        t: Times of the integrator's steps, from zero to the heelstrike, shape (n,).
        x: States there, shape (n, 4); the last one is just before the heelstrike.
    """

    t: Array
    x: Array


class FellError(ValueError):
    """No heel struck ahead of the hip."""


def _swing_until(rate: Rate, start: Array, gap: Callable[[Array], float], patience: float) -> Swing:
    """Follow ``rate`` until ``gap`` rises to zero with theta < 0, located to rounding.

    The gap, phi - 2 theta, rises from zero as the swing begins, which does not count, falls
    through zero as the legs pass each other, and comes back to it as the heel strikes.
    """

    def strike(t: float, x: Array) -> float:
        return gap(x) if t > 0 else 1.0

    strike.terminal, strike.direction = True, 1  # type: ignore[attr-defined]
    run = solve_ivp(
        lambda _, x: rate(x),
        (0, patience), start, "DOP853", events=strike, rtol=1e-12, atol=1e-13,
        max_step=0.02 * patience,
    )  # fmt: skip
    if not run.t_events[0].size or run.y[0, -1] >= 0:
        raise FellError(f"no heelstrike ahead within {patience}, from {start}")
    return Swing(run.t, run.y.T)


# Simplest walker


def simplest_rate(x: Array, gamma: float) -> Array:
    """Return x_dot, shape (4,): an inverted pendulum, and a foot that hangs from its top.

    theta_ddot = sin(theta - gamma) and
    phi_ddot = theta_ddot + theta_dot^2 sin phi - cos(theta - gamma) sin phi.
    """
    theta, phi, theta_dot, phi_dot = x
    fall = np.sin(theta - gamma)
    pull = theta_dot**2 - np.cos(theta - gamma)
    return np.array([theta_dot, phi_dot, fall, fall + pull * np.sin(phi)])


def simplest_strike(x: Array) -> Array:
    """Return the state after the heelstrike, shape (4,), for one just before it.

    The hip keeps its angular momentum about the new foot, cos(2 theta) of the speed; the light
    foot behind, at rest until now, gets no velocity across its leg.
    """
    theta, _, theta_dot, _ = x
    kept = np.cos(2 * theta)
    return np.array([-theta, -2 * theta, kept * theta_dot, kept * (1 - kept) * theta_dot])


def simplest_swing(start: Array, gamma: float) -> Swing:
    """Return the swing, from a state after a heelstrike to the next; ``FellError`` without one."""
    return _swing_until(
        lambda x: simplest_rate(x, gamma), start, lambda x: float(x[1] - 2 * x[0]), PATIENCE
    )


def simplest_start(theta: float, theta_dot: float) -> Array:
    """Return the whole state after a heelstrike: two numbers give it."""
    kept = 1 - np.cos(2 * theta)
    return np.array([theta, 2 * theta, theta_dot, kept * theta_dot])


def simplest_step(section: Array, gamma: float) -> Array:
    """Return (theta, theta_dot) after the next heelstrike, shape (2,), of those after this one."""
    start = simplest_start(float(section[0]), float(section[1]))
    return simplest_strike(simplest_swing(start, gamma).x[-1])[[0, 2]]


def simplest_gait(gamma: float, guess: Array) -> tuple[Array, float]:
    """Return (theta, theta_dot) that a step repeats, shape (2,), and the period in sqrt(l / g)."""
    section = fsolve(lambda s: simplest_step(s, gamma) - s, guess, xtol=1e-13)
    start = simplest_start(float(section[0]), float(section[1]))
    return np.asarray(section), float(simplest_swing(start, gamma).t[-1])


def simplest_multipliers(section: Array, gamma: float, h: float = 1e-5) -> Array:
    """Return the eigenvalues of a step's derivative, complex, shape (2,); stable within one."""
    columns = [
        (simplest_step(section + h * e, gamma) - simplest_step(section - h * e, gamma)) / (2 * h)
        for e in np.eye(2)
    ]
    return np.asarray(np.linalg.eigvals(np.array(columns).T))


def simplest_speed(theta: float, gamma: float) -> float:
    """Return the theta_dot after a heelstrike of any gait that repeats with ``theta``.

    What a step falls, 2 sin(theta) sin(gamma), is what the heelstrike takes,
    theta_dot^2 tan(2 theta)^2 / 2.
    """
    return float(-2 * np.sqrt(np.sin(theta) * np.sin(gamma)) / np.tan(2 * theta))


def simplest_period(theta: float, theta_dot: float, gamma: float) -> float:
    """Return how long the stance leg takes from theta to -theta, by quadrature of its energy."""

    def slowness(angle: float) -> float:
        return float(
            1 / np.sqrt(theta_dot**2 + 2 * (np.cos(theta - gamma) - np.cos(angle - gamma)))
        )

    return float(quad(slowness, -theta, theta, epsabs=1e-13, epsrel=1e-13)[0])


# Compass


@dataclass(frozen=True)
class Compass:
    """A hip of mass ``m_h`` on two legs of length ``l``, each with a mass ``m`` at one point.

    Attributes:
        m_h: Hip in [kg].
        m: One leg in [kg].
        l: Leg in [m].
        b: From the hip down to the leg's mass in [m]; at ``b = l`` it is the foot.
        g: Gravity in [m/s^2].
        gamma: Slope in [rad].
    """

    m_h: float = 10.0
    m: float = 5.0
    l: float = 1.0  # noqa: E741
    b: float = 0.5
    g: float = 9.81
    gamma: float = 0.0525

    @property
    def a(self) -> float:
        """From the foot up to the leg's mass in [m]."""
        return self.l - self.b

    @property
    def mass(self) -> float:
        """The whole in [kg]."""
        return self.m_h + 2 * self.m


def compass_points(theta: float, psi: float, walker: Compass) -> Array:
    """Return hip, stance mass, swing mass and swing foot from the stance foot, shape (4, 2)."""
    stance = np.array([-np.sin(theta), np.cos(theta)])
    swing = np.array([np.sin(psi), -np.cos(psi)])
    hip = walker.l * stance
    return np.array([hip, walker.a * stance, hip + walker.b * swing, hip + walker.l * swing])


def compass_velocities(x: Array, walker: Compass) -> Array:
    """Return the velocities of these points, shape (4, 2), while the stance foot rests."""
    theta, psi, theta_dot, psi_dot = x
    stance = -theta_dot * np.array([np.cos(theta), np.sin(theta)])
    swing = psi_dot * np.array([np.cos(psi), np.sin(psi)])
    hip = walker.l * stance
    return np.array([hip, walker.a * stance, hip + walker.b * swing, hip + walker.l * swing])


def compass_mass_matrix(theta: float, psi: float, walker: Compass) -> Array:
    """Return M of T = q_dot M q_dot / 2, shape (2, 2).

    The hip moves by l theta_dot, the stance mass by a theta_dot, the swing mass by both legs.
    """
    m, l, b = walker.m, walker.l, walker.b  # noqa: E741
    cross = -m * l * b * np.cos(theta - psi)
    carried = (walker.m_h + m) * l**2 + m * walker.a**2
    return np.array([[carried, cross], [cross, m * b**2]])


def compass_coriolis(x: Array, walker: Compass) -> Array:
    """Return C of M q_ddot + C q_dot + G = 0, shape (2, 2), with M_dot - 2 C skew."""
    theta, psi, theta_dot, psi_dot = x
    pull = walker.m * walker.l * walker.b * np.sin(theta - psi)
    return np.array([[0.0, -pull * psi_dot], [pull * theta_dot, 0.0]])


def compass_gravity(theta: float, psi: float, walker: Compass) -> Array:
    """Return G = dV/dq in [N m], shape (2,)."""
    lifted = (walker.m_h + walker.m) * walker.l + walker.m * walker.a
    tilted = np.sin([theta - walker.gamma, psi - walker.gamma])
    return np.array([-lifted * walker.g * tilted[0], walker.m * walker.b * walker.g * tilted[1]])


def compass_rate(x: Array, walker: Compass) -> Array:
    """Return x_dot, shape (4,)."""
    M, C = compass_mass_matrix(x[0], x[1], walker), compass_coriolis(x, walker)
    pull = -C @ x[2:] - compass_gravity(x[0], x[1], walker)
    return np.concatenate([x[2:], np.linalg.solve(M, pull)])


def compass_kinetic_energy(x: Array, walker: Compass) -> float:
    """Return T in [J], from the three masses' velocities."""
    squares = (compass_velocities(x, walker)[:3] ** 2).sum(axis=1)
    return float(np.array([walker.m_h, walker.m, walker.m]) @ squares) / 2


def compass_energy(x: Array, walker: Compass) -> float:
    """Return T + V in [J], V measured from the stance foot."""
    up = np.array([-np.sin(walker.gamma), np.cos(walker.gamma)])
    heights = compass_points(x[0], x[1], walker)[:3] @ up
    V = walker.g * np.array([walker.m_h, walker.m, walker.m]) @ heights
    return compass_kinetic_energy(x, walker) + float(V)


def compass_strike(x: Array, walker: Compass) -> Array:
    """Return the state after the heelstrike, shape (4,), legs relabelled.

    The impact acts at the new foot and the old one leaves the ground unhindered. So the whole keeps
    its angular momentum about the new foot, and the leg that was stance its own about the hip.
    """
    after = np.array([x[1], x[0], 0.0, 0.0])
    before = _strike_momenta(x, walker, struck=False)
    units = [np.array([*after[:2], *e]) for e in np.eye(2)]
    columns = np.array([_strike_momenta(unit, walker, struck=True) for unit in units]).T
    return np.array([*after[:2], *np.linalg.solve(columns, before)])


def _strike_momenta(x: Array, walker: Compass, struck: bool) -> Array:
    """Return two angular momenta in [kg m^2/s], shape (2,), which the strike keeps.

    Of the whole about the new foot, and of the leg that is stance before and swing after about the
    hip. Before, the new foot is the swing foot; once ``struck``, the stance foot.
    """
    points, velocities = compass_points(x[0], x[1], walker), compass_velocities(x, walker)
    foot, trailing = (np.zeros(2), 2) if struck else (points[3], 1)
    masses = np.array([walker.m_h, walker.m, walker.m])
    whole = masses @ _cross(points[:3] - foot, velocities[:3])
    leg = walker.m * _cross(points[trailing] - points[0], velocities[trailing])
    return np.array([whole, leg])


def compass_strike_by_impulse(x: Array, walker: Compass) -> Array:
    """Return the same state, shape (4,), from four coordinates and an impulse at the new foot.

    Coordinates: the old stance foot's place, theta and psi. M (v+ - v-) = J^T L with J v+ = 0,
    J of the swing foot.
    """
    theta, psi = x[:2]
    units = [np.array([theta, psi, *e]) for e in np.eye(2)]
    turns = np.stack([compass_velocities(unit, walker) for unit in units], axis=-1)
    J = np.concatenate([np.tile(np.eye(2), (4, 1, 1)), turns], axis=2)  # of the points, (4, 2, 4)
    masses = np.array([walker.m_h, walker.m, walker.m])
    M = np.einsum("p,pij,pik->jk", masses, J[:3], J[:3])
    saddle = np.block([[M, -J[3].T], [J[3], np.zeros((2, 2))]])
    momentum = M @ np.array([0, 0, x[2], x[3]])
    v = np.linalg.solve(saddle, np.concatenate([momentum, np.zeros(2)]))
    return np.array([psi, theta, v[3], v[2]])


def compass_swing(start: Array, walker: Compass) -> Swing:
    """Return the swing, from a state after a heelstrike to the next; ``FellError`` without one."""
    patience = PATIENCE * float(np.sqrt(walker.l / walker.g))
    return _swing_until(
        lambda x: compass_rate(x, walker), start, lambda x: float(-x[0] - x[1]), patience
    )


def compass_step(section: Array, walker: Compass) -> Array:
    """Return (theta, theta_dot, psi_dot) after the next heelstrike, shape (3,); psi = -theta."""
    start = np.array([section[0], -section[0], section[1], section[2]])
    return compass_strike(compass_swing(start, walker).x[-1], walker)[[0, 2, 3]]


def compass_gait(walker: Compass, guess: Array) -> tuple[Array, float]:
    """Return (theta, theta_dot, psi_dot) that a step repeats, shape (3,), and its period in [s]."""
    section = fsolve(lambda s: compass_step(s, walker) - s, guess, xtol=1e-12)
    start = np.array([section[0], -section[0], section[1], section[2]])
    return np.asarray(section), float(compass_swing(start, walker).t[-1])


def light_footed(beta: float, gamma: float) -> Compass:
    """Return the compass that becomes the simplest walker as beta = m / m_h goes to zero."""
    return Compass(m_h=1.0, m=beta, l=1.0, b=1.0, g=1.0, gamma=gamma)


def _cross(r: Array, p: Array) -> Array:
    """Return r x p of plane vectors, shape (...)."""
    return np.asarray(r[..., 0] * p[..., 1] - r[..., 1] * p[..., 0])
