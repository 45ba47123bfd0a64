"""A neutrally buoyant prolate ellipsoid in an ideal fluid: Lamb's added mass and Kirchhoff's law.

Body axes: x forward along the long semi-axis a, z up; the centre of mass is the origin. Twist
(V, W): velocity of the origin in [m/s] and turn rate in [rad/s], both along the body axes.
Inputs u = (surge, pitch, yaw): a force along x in [N] and torques about y and z in [N m].

The added mass is found three ways: Lamb's integrals by quadrature, their closed form for a prolate
spheroid, and the potential of sources between the foci, checked against the flow's own boundary
condition and integrated over the hull.

Sources:
    Lamb, Hydrodynamics, 6th ed., 1932, chapter V (ellipsoid) and chapter VI (Kirchhoff).
    Leonard, Stability of a bottom-heavy underwater vehicle, Automatica 33(3):331-346, 1997.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp
from scipy.special import ellipk

Array: TypeAlias = NDArray[np.float64]
Inputs: TypeAlias = Callable[[float], Array]  # time in [s] -> (surge, pitch, yaw)

CONTROLS = ("surge", "pitch", "yaw")
UP = np.array([0.0, 0.0, 1.0])


# Added mass


def lamb_coefficients(axes: Array) -> Array:
    """Lamb's alpha, beta, gamma of an ellipsoid by quadrature, shape (3,); they add up to 2.

    alpha_i = a b c integral from 0 to infinity of d lambda / ((a_i^2 + lambda) Delta), with
    Delta^2 = (a^2 + lambda) (b^2 + lambda) (c^2 + lambda). With lambda = s^2 / (1 - s)^2 the
    integrand is smooth on [0, 1].
    """

    def integrand(s: float, i: int) -> float:
        root = s / (1 - s)
        delta = np.sqrt(np.prod(axes**2 + root**2))
        return float(2 * root / (1 - s) ** 2 / ((axes[i] ** 2 + root**2) * delta))

    integrals = [quad(integrand, 0, 1, args=(i,), epsabs=0, epsrel=1e-13)[0] for i in range(3)]
    return np.asarray(np.prod(axes) * np.array(integrals))


def spheroid_coefficients(a: float, b: float) -> Array:
    """The same in closed form for a prolate spheroid of semi-axes a > b = c, shape (3,)."""
    e = np.sqrt(1 - (b / a) ** 2)
    logarithm = np.log((1 + e) / (1 - e))
    along = 2 * (1 - e**2) / e**3 * (logarithm / 2 - e)
    across = 1 / e**2 - (1 - e**2) / (2 * e**3) * logarithm
    return np.array([along, across, across])


def added_mass_factors(axes: Array, coefficients: Array) -> Array:
    """Added mass over the displaced fluid's own, shape (6,): along x, y, z and about x, y, z.

    About x: (b^2 - c^2)^2 (gamma - beta) / (2 (b^2 - c^2) + (b^2 + c^2) (beta - gamma)), divided
    by b^2 + c^2; none about an axis of symmetry.
    """
    turning = np.zeros(3)
    for i, (j, k) in enumerate([(1, 2), (2, 0), (0, 1)]):
        total, gap = axes[j] ** 2 + axes[k] ** 2, axes[j] ** 2 - axes[k] ** 2
        across = coefficients[k] - coefficients[j]
        if abs(gap) > 1e-12 * total:
            turning[i] = gap**2 * across / (2 * gap - total * across) / total
    return np.concatenate([coefficients / (2 - coefficients), turning])


def potential_flow_factors(a: float, b: float, nodes: int = 400) -> tuple[Array, float]:
    """Added mass factors along x, along z and about y from the flow itself, and how well it fits.

    The potential is a line of sources between the foci: of density s for surge, doublets across
    of density f^2 - s^2 for heave, and s (f^2 - s^2) for pitch. One constant each must meet
    d phi / d n = n . (velocity of the hull); the kinetic energy is then an integral over the hull.

    Returns:
        The factors, shape (3,), and the largest residual of the boundary condition.
    """
    x, r, normal, area = _meridian(a, b, nodes)
    moment = a**2 + b**2
    surge = _match(*_sources(a, b, x, r, nodes), normal, normal[0])
    heave = _match(*_doublets(a, b, x, r, nodes, power=0), normal, normal[1])
    pitch = _match(*_doublets(a, b, x, r, nodes, power=1), normal, r * normal[0] - x * normal[1])
    volume = 4 / 3 * np.pi * a * b**2
    energies = np.array([area @ flow[0] for flow in (surge, heave, pitch)])
    # Around the hull's axis cos^2 of the azimuth integrates to half the circle.
    circle = np.array([2 * np.pi, np.pi, np.pi])
    scale = np.array([1.0, 1.0, moment / 5])
    return -circle * energies / volume / scale, max(flow[1] for flow in (surge, heave, pitch))


def _meridian(a: float, b: float, nodes: int) -> tuple[Array, Array, Array, Array]:
    """Points (x, r) of the hull's upper outline, the outward normal (2, n), and r ds weights."""
    knots, weights = np.polynomial.legendre.leggauss(nodes)
    angle, weights = np.pi / 2 * (knots + 1), np.pi / 2 * weights
    x, r = a * np.cos(angle), b * np.sin(angle)
    slope = np.hypot(a * np.sin(angle), b * np.cos(angle))
    normal = np.array([b * np.cos(angle), a * np.sin(angle)]) / slope
    return x, r, normal, weights * slope * r


def _line(a: float, b: float, nodes: int) -> tuple[Array, Array, float]:
    focus = float(np.sqrt(a**2 - b**2))
    knots, weights = np.polynomial.legendre.leggauss(nodes)
    return focus * knots, focus * weights, focus


def _sources(a: float, b: float, x: Array, r: Array, nodes: int) -> tuple[Array, Array]:
    """Potential (n,) and its gradient (2, n) along x and r of sources of density s."""
    s, weights, _ = _line(a, b, nodes)
    along, across = x[:, None] - s, r[:, None]
    distance = np.hypot(along, across)
    density = weights * s
    gradient = -np.array([along / distance**3 @ density, across / distance**3 @ density])
    return 1 / distance @ density, gradient


def _doublets(
    a: float, b: float, x: Array, r: Array, nodes: int, *, power: int
) -> tuple[Array, Array]:
    """The same at the azimuth of the doublets' axis, of density s^power (f^2 - s^2)."""
    s, weights, focus = _line(a, b, nodes)
    along, across = x[:, None] - s, r[:, None]
    distance = np.hypot(along, across)
    density = weights * s**power * (focus**2 - s**2)
    slopes = [-3 * across * along / distance**5, 1 / distance**3 - 3 * across**2 / distance**5]
    return across / distance**3 @ density, np.array([slope @ density for slope in slopes])


def _match(potential: Array, gradient: Array, normal: Array, wanted: Array) -> tuple[Array, float]:
    """Scale a potential to the wanted normal velocity: (phi * d phi / d n, largest misfit)."""
    flux = (gradient * normal).sum(axis=0)
    scale = flux @ wanted / (flux @ flux)
    return scale * potential * wanted, float(np.abs(scale * flux - wanted).max())


# The vehicle


@dataclass(frozen=True)
class Hull:
    """A homogeneous prolate ellipsoid of semi-axes a, a/5, a/5 with the density of the fluid.

    The centre of buoyancy is at (0, 0, h). Drags as in ``drag``.
    """

    rho: float
    a: float
    g: float
    h: float
    d_u: float = 0.0
    d_v: float = 0.0
    d_p: float = 0.0
    d_q: float = 0.0
    d_uu: float = 0.0
    d_vv: float = 0.0
    d_qq: float = 0.0

    @property
    def m(self) -> float:
        """Mass in [kg], that of the displaced fluid."""
        return 4 / 3 * np.pi * self.rho * self.a**3 / 25

    @property
    def weight(self) -> float:
        """In [N]."""
        return self.m * self.g

    @property
    def inertia(self) -> Array:
        """Mass (three times) and moments about x, y, z of hull and fluid together, shape (6,)."""
        axes = self.a * np.array([1.0, 0.2, 0.2])
        moments = self.m / 5 * ((axes**2).sum() - axes**2)
        factors = added_mass_factors(axes, spheroid_coefficients(self.a, self.a / 5))
        return np.asarray(np.append(np.full(3, self.m), moments) * (1 + factors))


def drag(twist: Array, hull: Hull) -> Array:
    """Force and torque along the body axes, shape (6,); the quadratic parts axis by axis."""
    linear = np.array([hull.d_u, hull.d_v, hull.d_v, hull.d_p, hull.d_q, hull.d_q])
    quadratic = np.array([hull.d_uu, hull.d_vv, hull.d_vv, 0.0, hull.d_qq, hull.d_qq])
    return np.asarray(-(linear + quadratic * np.abs(twist)) * twist)


def buoyancy_torque(gamma: Array, hull: Hull) -> Array:
    """Torque in [N m] of the buoyancy at h e3 against the weight at the origin, shape (3,).

    The buoyancy is m g gamma, where gamma is the world's up along the body axes, so the torque is
    h e3 x m g gamma: it turns the body's z axis towards up.
    """
    return np.asarray(hull.h * hull.weight * np.cross(UP, gamma))


def kirchhoff(twist: Array, gamma: Array, u: Array, hull: Hull) -> Array:
    """Time derivative of the momenta (P, Pi), shape (6,), along the body axes.

    P_dot = P x W + force, Pi_dot = Pi x W + P x V + torque.
    """
    V, W = twist[:3], twist[3:]
    P, Pi = hull.inertia[:3] * V, hull.inertia[3:] * W
    load = drag(twist, hull) + np.array([u[0], 0.0, 0.0, 0.0, u[1], u[2]])
    force = np.cross(P, W) + load[:3]
    torque = np.cross(Pi, W) + np.cross(P, V) + load[3:] + buoyancy_torque(gamma, hull)
    return np.append(force, torque)


def rotation_matrix(quaternion: Array) -> Array:
    """R from a unit quaternion (x, y, z, w): v -> v + 2 w (n x v) + 2 n x (n x v)."""
    n, w = quaternion[:3], quaternion[3]
    cross = skew(n)
    return np.asarray(np.eye(3) + 2 * w * cross + 2 * cross @ cross)


def skew(n: Array) -> Array:
    """The matrix of v -> n x v, shape (3, 3)."""
    return np.asarray(np.cross(n, np.eye(3)).T)


def quaternion_rate(quaternion: Array, W: Array) -> Array:
    """Derivative of (x, y, z, w) at the turn rate W along the body axes: half of q (W, 0)."""
    n, w = quaternion[:3], quaternion[3]
    return np.append(w * W + np.cross(n, W), -n @ W) / 2


def accelerations(R: Array, twist: Array, u: Array, hull: Hull) -> Array:
    """World acceleration of the origin in [m/s^2], and W_dot along the body axes, shape (6,)."""
    momentum_rate = kirchhoff(twist, R.T @ UP, u, hull)
    twist_rate = momentum_rate / hull.inertia
    carried = np.cross(twist[3:], twist[:3])
    return np.append(R @ (twist_rate[:3] + carried), twist_rate[3:])


def energy(R: Array, twist: Array, hull: Hull) -> tuple[float, float]:
    """Kinetic energy of hull and fluid, and potential energy (0 upright), in [J]."""
    potential = hull.h * hull.weight * (1.0 - R[2, 2])
    return float(hull.inertia @ twist**2) / 2, float(potential)


def impulse(place: Array, R: Array, twist: Array, hull: Hull) -> tuple[Array, Array]:
    """Linear and angular momentum in the world, about its origin; shapes (3,)."""
    linear, spin = R @ (hull.inertia[:3] * twist[:3]), R @ (hull.inertia[3:] * twist[3:])
    return linear, spin + np.cross(place, linear)


def simulate(
    place: Array, R: Array, twist: Array, inputs: Inputs, t: Array, hull: Hull
) -> tuple[Array, Array, Array]:
    """Integrate Kirchhoff's equations in the momenta and the nine numbers of R.

    Returns:
        Places (n, 3), attitudes (n, 3, 3) and twists (n, 6) at the times ``t``.
    """

    def slope(time: float, y: Array) -> Array:
        R, now = y[3:12].reshape(3, 3), y[12:] / hull.inertia
        rate = kirchhoff(now, R.T @ UP, inputs(time), hull)
        return np.concatenate([R @ now[:3], (R @ skew(now[3:])).ravel(), rate])

    first = np.concatenate([place, R.ravel(), hull.inertia * twist])
    span = (float(t[0]), float(t[-1]))
    y = solve_ivp(slope, span, first, "DOP853", t_eval=t, rtol=1e-13, atol=1e-13).y.T
    return y[:, :3], y[:, 3:12].reshape(-1, 3, 3), y[:, 12:] / hull.inertia


# Closed forms


def munk_rate(speed: float, hull: Hull) -> float:
    """Growth rate in [1/s] of a small yaw or pitch while moving along the long axis, h = 0.

    From m3 w_dot = m1 U q and I2 q_dot = (m3 - m1) U w.
    """
    m1, m3, I2 = hull.inertia[[0, 2, 4]]
    return float(speed * np.sqrt(m1 * (m3 - m1) / (m3 * I2)))


def crossflow_frequency(speed: float, hull: Hull) -> float:
    """Frequency in [rad/s] with which the nose swings about motion along a short axis, h = 0.

    From m1 u_dot = m2 U r and I3 r_dot = (m1 - m2) U u for motion along y.
    """
    m1, m2, I3 = hull.inertia[[0, 1, 5]]
    return float(speed * np.sqrt(m2 * (m2 - m1) / (m1 * I3)))


def terminal_speed(force: float, hull: Hull) -> float:
    """The positive root in [m/s] of d_u U + d_uu U^2 = force > 0."""
    root = np.sqrt(hull.d_u**2 + 4 * hull.d_uu * force)
    return float(2 * force / (hull.d_u + root))


def surge_run(t: Array, force: float, hull: Hull) -> Array:
    """Speed in [m/s] at the times ``t``, from rest, of m1 U_dot = force - d_u U - d_uu U^2.

    With the roots U1 > 0 > U2 of the right side, (U1 - U) / (U - U2) decays exponentially.
    """
    top = terminal_speed(force, hull)
    low = -force / hull.d_uu / top
    decay = np.exp(-hull.d_uu * (top - low) / hull.inertia[0] * t)
    return np.asarray(top * (1 - decay) / (1 - top / low * decay))


def righting_frequency(axis: int, hull: Hull) -> float:
    """Frequency in [rad/s] of small roll (axis 0) or pitch (axis 1) with the buoyancy above."""
    return float(np.sqrt(hull.h * hull.weight / hull.inertia[3 + axis]))


def righting_period(axis: int, amplitude: float, hull: Hull) -> float:
    """Period in [s] at any amplitude: roll or pitch from rest alone is a pendulum."""
    return float(4 * ellipk(np.sin(amplitude / 2) ** 2) / righting_frequency(axis, hull))
