"""The upright rolling coin, solved by hand and by a second engine.

Configuration q = (x, y, psi, phi): contact point, heading, roll.  State x = (q, psi_dot, phi_dot).
Inputs u = (drive, steer): torque about the axle, torque about the vertical.  SI units throughout.

Sources:
    Bloch, Nonholonomic Mechanics and Control, 2nd ed., 2015, section 1.4 (vertical rolling disk):
        (I + m R^2) phi_ddot = u1, J psi_ddot = u2, with the two rolling constraints.
    Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, chapter 6:
        Lagrange's equations with Pfaffian constraints, M q_ddot = B u + w^T lambda.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp
from sympy.physics.mechanics import (
    KanesMethod,
    LagrangesMethod,
    Point,
    ReferenceFrame,
    RigidBody,
    dynamicsymbols,
    inertia,
)

Array = NDArray[np.float64]
Torques = Callable[[float], Array]  # time in [s] -> (drive, steer) in [N m]
Accelerations = Callable[[Array, Array], Array]  # (nx,), (2,) -> (psi_ddot, phi_ddot)
Symbols = Sequence[Any]  # SymPy is untyped

DRIVE, STEER = sp.symbols("drive steer")
STATES = ("x", "y", "psi", "phi", "psi_dot", "phi_dot")
CONTROLS = ("drive", "steer")


@dataclass(frozen=True)
class Coin:
    """A thin uniform disk of mass ``m`` in [kg] and radius ``R`` in [m]."""

    m: float = 1.0
    R: float = 0.25

    @property
    def axle(self) -> float:
        """Moment of inertia about the axle in [kg m^2]."""
        return self.m * self.R**2 / 2

    @property
    def diametral(self) -> float:
        """Moment of inertia about a diameter in [kg m^2]."""
        return self.m * self.R**2 / 4


def accelerations(x: Array, u: Array, coin: Coin) -> Array:
    """Closed form of (psi_ddot, phi_ddot), shape (..., 2); they do not depend on the state."""
    drive, steer = u[..., 0], u[..., 1]
    psi_ddot = steer / coin.diametral
    phi_ddot = drive / (coin.axle + coin.m * coin.R**2)
    return np.stack(np.broadcast_arrays(psi_ddot, phi_ddot, x[..., 0])[:2], axis=-1)


def velocity(x: Array, coin: Coin) -> Array:
    """Return q_dot, shape (..., 4), for states of shape (..., 6): the coin rolls without slip."""
    psi, psi_dot, phi_dot = x[..., 2], x[..., 4], x[..., 5]
    speed = coin.R * phi_dot
    return np.stack([speed * np.cos(psi), speed * np.sin(psi), psi_dot, phi_dot], axis=-1)


def state_derivative(x: Array, u: Array, coin: Coin) -> Array:
    """Closed form of x_dot, shape (..., 6)."""
    return np.concatenate([velocity(x, coin), accelerations(x, u, coin)], axis=-1)


def mass_matrix(coin: Coin) -> Array:
    """M in the full coordinates (x, y, psi, phi), shape (4, 4): constant and diagonal."""
    return np.diag([coin.m, coin.m, coin.diametral, coin.axle])


def kinetic_energy(q_dot: Array, coin: Coin) -> float:
    """T in [J] for any q_dot of shape (4,), slipping or not (Koenig: centre plus spin)."""
    vx, vy, psi_dot, phi_dot = q_dot
    translation = coin.m * (vx**2 + vy**2)
    rotation = coin.diametral * psi_dot**2 + coin.axle * phi_dot**2
    return float(translation + rotation) / 2


def free_directions(psi: float, coin: Coin) -> Array:
    """S(q), shape (4, 2): q_dot = S (psi_dot, phi_dot) spans what the constraints leave free."""
    along = coin.R * np.array([np.cos(psi), np.sin(psi)])
    return np.array([[0.0, along[0]], [0.0, along[1]], [1.0, 0.0], [0.0, 1.0]])


def configuration_acceleration(x: Array, u: Array, coin: Coin) -> Array:
    """Return q_ddot, shape (4,): the time derivative of ``velocity`` by the product rule."""
    psi, psi_dot, phi_dot = x[2], x[4], x[5]
    psi_ddot, phi_ddot = accelerations(x, u, coin)
    forward, sideways = coin.R * phi_ddot, coin.R * phi_dot * psi_dot
    c, s = np.cos(psi), np.sin(psi)
    return np.array([forward * c - sideways * s, forward * s + sideways * c, psi_ddot, phi_ddot])


def contact_force(x: Array, u: Array, coin: Coin) -> Array:
    """Friction on the coin in [N]: (along the heading, to its left), by Newton for the centre."""
    _, phi_ddot = accelerations(x, u, coin)
    return np.array([coin.m * coin.R * phi_ddot, coin.m * coin.R * x[5] * x[4]])


def undriven_circle(start: Array, t: Array, coin: Coin) -> Array:
    """States at times ``t``, shape (len(t), 6), without torque: a circle of radius R s / Omega.

    Args:
        start: State at t = 0, shape (6,), with psi_dot (Omega) not zero; s is phi_dot.
    """
    x, y, psi, phi, yaw_rate, spin = start
    radius, heading = coin.R * spin / yaw_rate, psi + yaw_rate * t
    across = radius * (np.sin(heading) - np.sin(psi))
    up = -radius * (np.cos(heading) - np.cos(psi))
    rates = [np.full_like(t, yaw_rate), np.full_like(t, spin)]
    return np.stack([x + across, y + up, heading, phi + spin * t, *rates], axis=-1)


def constant_torque_motion(start: Array, u: Array, t: float, coin: Coin) -> Array:
    """State at time ``t``, shape (6,): psi, phi are quadratic in t, the path is a quadrature."""
    a, b = accelerations(start, u, coin)

    def moved(tau: float) -> Array:
        psi = start[2] + start[4] * tau + a * tau**2 / 2
        phi = start[3] + start[5] * tau + b * tau**2 / 2
        return np.array([start[0], start[1], psi, phi, start[4] + a * tau, start[5] + b * tau])

    def speed(tau: float, axis: int) -> float:
        return float(velocity(moved(tau), coin)[axis])

    end = moved(t)
    for axis in (0, 1):
        distance, _ = quad(speed, 0.0, t, args=(axis,), epsabs=1e-12, epsrel=1e-12, limit=400)
        end[axis] += distance
    return end


def constraint_matrix(psi: float, coin: Coin) -> Array:
    """w(q), shape (2, 4): row 1 rolls along the heading, row 2 does not slip sideways."""
    c, s = np.cos(psi), np.sin(psi)
    return np.array([[c, s, 0.0, -coin.R], [-s, c, 0.0, 0.0]])


def multiplier_form(q: Array, q_dot: Array, u: Array, coin: Coin) -> tuple[Array, Array]:
    """Return (q_ddot, lambda), shapes (4,) and (2,), from M q_ddot = B u + w^T lambda.

    The constraint enters differentiated, w q_ddot + w_dot q_dot = 0, without stabilisation.
    """
    w, inverse_mass = constraint_matrix(q[2], coin), np.linalg.inv(mass_matrix(coin))
    c, s = np.cos(q[2]), np.sin(q[2])
    w_dot = q_dot[2] * np.array([[-s, c, 0.0, 0.0], [-c, -s, 0.0, 0.0]])
    applied = np.array([0.0, 0.0, u[1], u[0]])
    unforced = w @ inverse_mass @ applied + w_dot @ q_dot
    multipliers = -np.linalg.solve(w @ inverse_mass @ w.T, unforced)
    return inverse_mass @ (applied + w.T @ multipliers), multipliers


def multiplier_simulation(start: Array, torques: Torques, t: Array, coin: Coin) -> Array:
    """Integrate all four coordinates with multipliers; the start obeys the constraints.

    Returns:
        (q, q_dot) at the times ``t``, shape (len(t), 8).
    """

    def slope(time: float, state: Array) -> Array:
        q, q_dot = state[:4], state[4:]
        q_ddot, _ = multiplier_form(q, q_dot, torques(time), coin)
        return np.concatenate([q_dot, q_ddot])

    first = np.concatenate([start[:4], velocity(start, coin)])
    span = (float(t[0]), float(t[-1]))
    run = solve_ivp(slope, span, first, method="DOP853", t_eval=t, rtol=1e-12, atol=1e-13)
    return np.asarray(run.y.T, dtype=np.float64)


def lagrange_accelerations(coin: Coin) -> Accelerations:
    """(psi_ddot, phi_ddot) by SymPy's LagrangesMethod: four coordinates and two multipliers."""
    q = dynamicsymbols("x y psi phi")
    rates = [coordinate.diff() for coordinate in q]
    frame, body, slip, torques = _coin_in_space(q, rates, coin)
    method = LagrangesMethod(
        body.kinetic_energy(frame), q, nonhol_coneqs=slip, forcelist=torques, frame=frame
    )
    method.form_lagranges_equations()
    return _solver(method.mass_matrix_full, method.forcing_full, q, rates, coin, rows=(6, 7))


def kane_accelerations(coin: Coin) -> Accelerations:
    """(psi_ddot, phi_ddot) by SymPy's KanesMethod: two independent speeds, no multipliers."""
    q = dynamicsymbols("x y psi phi")
    x_d, y_d, psi_d, phi_d = speeds = dynamicsymbols("x_d y_d psi_d phi_d")
    frame, body, slip, torques = _coin_in_space(q, speeds, coin)
    method = KanesMethod(
        frame,
        q,
        [psi_d, phi_d],
        kd_eqs=[v - c.diff() for v, c in zip(speeds, q, strict=True)],
        u_dependent=[x_d, y_d],
        velocity_constraints=slip,
    )
    method.kanes_equations([body], torques)
    return _solver(method.mass_matrix_full, method.forcing_full, q, speeds, coin, rows=(4, 5))


def _coin_in_space(q: Symbols, rates: Symbols, coin: Coin) -> tuple[Any, Any, list[Any], list[Any]]:
    """Return the inertial frame, the body, the contact's slip velocity (two scalars), the loads."""
    world = ReferenceFrame("N")
    fork, disk = ReferenceFrame("F"), ReferenceFrame("D")
    fork.orient_axis(world, world.z, q[2])
    fork.set_ang_vel(world, rates[2] * world.z)
    disk.orient_axis(fork, fork.y, q[3])
    disk.set_ang_vel(fork, rates[3] * fork.y)
    centre, contact = Point("C"), Point("P")
    centre.set_vel(world, rates[0] * world.x + rates[1] * world.y)
    contact.set_pos(centre, -coin.R * world.z)
    slip = contact.v2pt_theory(centre, world, disk)
    # The diametral inertia is the same about every diameter: the fork's axes describe it too.
    tensor = inertia(fork, coin.diametral, coin.axle, coin.diametral)
    body = RigidBody("coin", centre, disk, coin.m, (tensor, centre))
    torques = [(disk, DRIVE * fork.y + STEER * world.z)]
    return world, body, [slip.dot(world.x), slip.dot(world.y)], torques


def _solver(
    mass: Any, forcing: Any, q: Symbols, rates: Symbols, coin: Coin, *, rows: tuple[int, int]
) -> Accelerations:
    """Solve mass @ unknowns = forcing with numbers; ``rows`` hold psi_ddot and phi_ddot."""
    plain = sp.symbols("rate:4")
    numbers = dict(zip(rates, plain, strict=True))
    arguments = (*q, *plain, DRIVE, STEER)
    system = sp.lambdify(arguments, [mass.subs(numbers), forcing.subs(numbers)])

    def solve(x: Array, u: Array) -> Array:
        M, f = system(*x[:4], *velocity(x, coin), *u)
        return np.asarray(np.linalg.solve(M, f).ravel()[list(rows)], dtype=np.float64)

    return solve
