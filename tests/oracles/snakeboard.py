"""The snakeboard by multipliers in six coordinates, and by its one momentum equation.

Coordinates q = (x, y, theta, psi, phi_b, phi_f): the board's centre and heading, the rotor
relative to the board, and how far the back and the front wheel pair are turned. The steering
phi turns them against each other, phi_b = phi = -phi_f. Inputs u = (tau_psi, tau_phi). SI units.

Three derivations that share no formula: multipliers over all six coordinates, with the coupling
of the wheel pairs as a third constraint; the momentum equation; and SymPy's projection of
Lagrange's equations on the direction that the wheels leave free.

Sources:
    Lewis, Ostrowski, Murray, Burdick, Nonholonomic mechanics and locomotion: the snakeboard
        example, ICRA 1994: the machine and its gaits.
    Bullo, Lewis, Kinematic controllability and motion planning for the snakeboard, 2003: its
        rest-to-rest motions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array: TypeAlias = NDArray[np.float64]
Inputs: TypeAlias = Callable[[float], Array]  # time in [s] -> (tau_psi, tau_phi) in [N m]

NAMES = ("x", "y", "theta", "psi", "phi")
CONTROLS = ("tau_psi", "tau_phi")
SPREAD = np.vstack([np.eye(5), [0.0, 0.0, 0.0, 0.0, -1.0]])  # six coordinates from NAMES


@dataclass(frozen=True)
class Board:
    """A snakeboard whose inertias about the vertical add up to m l^2.

    ``l`` is half the wheelbase in [m]; ``J_r`` belongs to the rotor, ``J_w`` to each wheel pair,
    in [kg m^2]; ``c_r`` is the rolling drag of a wheel pair in [N s/m], ``c_psi`` and ``c_phi``
    are the bearings' in [N m s]. Wheels of ``radius`` in [m] that roll have the moment ``I_s`` in
    [kg m^2] about their axle, which the sources leave out: 0 is the published machine.
    """

    m: float = 6.0
    l: float = 0.2  # noqa: E741
    J_r: float = 0.072
    J_w: float = 0.0013
    c_r: float = 0.0
    c_psi: float = 0.0
    c_phi: float = 0.0
    I_s: float = 0.0
    radius: float = 0.04

    @property
    def spin_mass(self) -> float:
        """Mass in [kg] that has the wheels' spin energy at the speed with which a pair rolls."""
        return self.I_s / self.radius**2

    @property
    def J(self) -> float:
        """Moment of inertia of the board alone in [kg m^2]."""
        return self.m * self.l**2 - self.J_r - 2 * self.J_w


# Multipliers, six coordinates


def kinetic_energy(q: Array, q_dot: Array, board: Board) -> float:
    """T in [J] for any rates of shape (6,), slipping sideways or not (Koenig, body by body)."""
    x_dot, y_dot, theta_dot, psi_dot, back_dot, front_dot = q_dot
    spins = np.array([0.0, psi_dot, back_dot, front_dot]) + theta_dot
    moments = np.array([board.J, board.J_r, board.J_w, board.J_w])
    rolling = board.spin_mass * (wheel_rows(q, board)[0][0] @ q_dot) ** 2
    return float(board.m * (x_dot**2 + y_dot**2) + moments @ spins**2 + rolling) / 2


def mass_matrix(board: Board) -> Array:
    """M over the six coordinates, shape (6, 6), without the wheels' spin: constant."""
    turning = np.eye(6)
    turning[3:, 2] = 1.0  # rotor and wheels turn with the board as well
    masses = np.diag([board.m, board.m, board.J, board.J_r, board.J_w, board.J_w])
    return np.asarray(turning.T @ masses @ turning)


def wheel_rows(q: Array, board: Board) -> tuple[Array, Array]:
    """Speeds of the back and front pair, along and across their headings, as rows of shape (2, 6).

    The pairs sit at -l and +l on the board, so theta_dot moves them by -+ l theta_dot sideways.
    """
    headings, turned, place = q[2] + q[4:], q[4:], np.array([-board.l, board.l])
    along, across = np.zeros((2, 6)), np.zeros((2, 6))
    along[:, 0], along[:, 1] = np.cos(headings), np.sin(headings)
    across[:, 0], across[:, 1] = -np.sin(headings), np.cos(headings)
    along[:, 2], across[:, 2] = place * np.sin(turned), place * np.cos(turned)
    return along, across


def constraint_matrix(q: Array, board: Board) -> Array:
    """w(q), shape (3, 6): neither pair slips sideways; the pairs turn against each other."""
    return np.vstack([wheel_rows(q, board)[1], [0.0, 0.0, 0.0, 0.0, 1.0, 1.0]])


def constraint_rate(q: Array, q_dot: Array, board: Board) -> Array:
    """Time derivative of w(q), shape (3, 6), by the product rule."""
    rate, place = np.zeros((3, 6)), np.array([-board.l, board.l])
    heading, turning = q[2] + q[4:], q_dot[2] + q_dot[4:]
    rate[:2, 0], rate[:2, 1] = -np.cos(heading) * turning, -np.sin(heading) * turning
    rate[:2, 2] = -place * np.sin(q[4:]) * q_dot[4:]
    return rate


def applied(q: Array, q_dot: Array, u: Array, board: Board) -> Array:
    """Generalised forces of the inputs and of all drags, shape (6,).

    A torque on phi does the work tau_phi dphi: half of it on each pair, with opposite signs.
    """
    steering = (u[1] - board.c_phi * (q_dot[4] - q_dot[5]) / 2) / 2
    torques = np.array([0.0, 0.0, 0.0, u[0] - board.c_psi * q_dot[3], steering, -steering])
    along, _ = wheel_rows(q, board)
    return np.asarray(torques - board.c_r * along.T @ (along @ q_dot))


def rolling_rate(q: Array, q_dot: Array, board: Board) -> Array:
    """Time derivative of the back pair's row of rolling speed, shape (6,)."""
    heading, turning = q[2] + q[4], q_dot[2] + q_dot[4]
    path = turning * np.array([-np.sin(heading), np.cos(heading)])
    return np.array([*path, -board.l * np.cos(q[4]) * q_dot[4], 0.0, 0.0, 0.0])


def multiplier_form(q: Array, q_dot: Array, u: Array, board: Board) -> Array:
    """Return q_ddot, shape (6,), from M q_ddot = F + w^T lambda and w q_ddot + w_dot q_dot = 0.

    The wheels' spin acts as a mass on the rolling speed a q_dot: a^T d/dt(a q_dot) for each kg.
    """
    w, a = constraint_matrix(q, board), wheel_rows(q, board)[0][0]
    M = mass_matrix(board) + board.spin_mass * np.outer(a, a)
    spin = board.spin_mass * a * (rolling_rate(q, q_dot, board) @ q_dot)
    matrix = np.block([[M, -w.T], [w, np.zeros((3, 3))]])
    bent = constraint_rate(q, q_dot, board) @ q_dot
    right = np.append(applied(q, q_dot, u, board) - spin, -bent)
    return np.asarray(np.linalg.solve(matrix, right)[:6])


def multiplier_simulation(start: Array, inputs: Inputs, t: Array, board: Board) -> Array:
    """Integrate all six coordinates, without stabilisation.

    Args:
        start: (q, q_dot) of NAMES, shape (10,), without slip.

    Returns:
        (q, q_dot) of NAMES at the times ``t``, shape (len(t), 10).
    """

    def slope(time: float, state: Array) -> Array:
        q, q_dot = state[:6], state[6:]
        return np.append(q_dot, multiplier_form(q, q_dot, inputs(time), board))

    first = np.append(SPREAD @ start[:5], SPREAD @ start[5:])
    span = (float(t[0]), float(t[-1]))
    run = solve_ivp(slope, span, first, "DOP853", t_eval=t, rtol=1e-12, atol=1e-13)
    return np.asarray(np.delete(run.y.T, [5, 11], axis=1))


# The momentum equation, of wheels without spin


def momentum(forward: float, phi: float, psi_dot: float, board: Board) -> float:
    """Return p in [kg m^2/s]: dT/dq_dot along the free direction, for the speed ``forward``.

    The free direction is (v_x, theta_dot) = (-2 l cos^2 phi, 2 sin phi cos phi).
    """
    swing = board.J_r * np.sin(phi) * np.cos(phi) * psi_dot
    return float(2 * swing - 2 * board.m * board.l * forward)


def forward_speed(p: Array, phi: Array, psi_dot: Array, board: Board) -> Array:
    """v_x in [m/s], of the board's centre along the board."""
    swing = board.J_r * np.sin(phi) * np.cos(phi) * psi_dot
    return np.asarray((swing - p / 2) / (board.m * board.l))


def yaw_rate(p: Array, phi: Array, psi_dot: Array, board: Board) -> Array:
    """theta_dot in [rad/s]."""
    swing = board.J_r * np.sin(phi) ** 2 * psi_dot
    return np.asarray((np.tan(phi) * p / 2 - swing) / (board.m * board.l**2))


def momentum_rate(p: float, phi: float, psi_dot: float, phi_dot: float, board: Board) -> float:
    """p_dot in [N m] without drag: the torques do not appear."""
    pumped = 2 * board.J_r * np.cos(phi) ** 2 * phi_dot * psi_dot
    return float(pumped - np.tan(phi) * phi_dot * p)


def rates(x: Array, board: Board) -> Array:
    """Rates of NAMES, shape (5,), of x = (q of NAMES, p, psi_dot, phi_dot), shape (8,)."""
    theta, phi, (p, psi_dot, phi_dot) = x[2], x[4], x[5:]
    forward = forward_speed(p, phi, psi_dot, board)
    turn = yaw_rate(p, phi, psi_dot, board)
    path = forward * np.array([np.cos(theta), np.sin(theta)])
    return np.array([*path, turn, psi_dot, phi_dot])


def reduced_form(x: Array, u: Array, board: Board) -> Array:
    """Return x_dot, shape (8,), of x = (q of NAMES, p, psi_dot, phi_dot), shape (8,).

    The drag of both pairs, whose speed is v_x / cos phi, brakes p by 4 c_r l v_x. The rotor obeys
    J_r (theta_ddot + psi_ddot) = tau_psi, where theta_ddot follows from yaw_rate.
    """
    phi, (p, psi_dot, phi_dot) = x[4], x[5:]
    q_dot, l2 = rates(x, board), board.m * board.l**2
    forward = forward_speed(p, phi, psi_dot, board)
    p_dot = momentum_rate(p, phi, psi_dot, phi_dot, board) + 4 * board.c_r * board.l * forward
    turned = phi_dot * (p / 2 / np.cos(phi) ** 2 - board.J_r * np.sin(2 * phi) * psi_dot) / l2
    known = turned + np.tan(phi) * p_dot / 2 / l2  # theta_ddot but for psi_ddot
    left = board.J_r * (1 - board.J_r * np.sin(phi) ** 2 / l2)
    psi_ddot = (u[0] - board.c_psi * psi_dot - board.J_r * known) / left
    phi_ddot = (u[1] - board.c_phi * phi_dot) / (2 * board.J_w)
    return np.array([*q_dot, p_dot, psi_ddot, phi_ddot])


def lagrange_residual() -> sp.Expr:
    """Lagrange's equations along the free direction, less the momentum equation: identically 0.

    Done with functions of time in SymPy; rolling without slip is put in after differentiating.
    """
    t, (m, l, J_r, J_w) = sp.Symbol("t"), sp.symbols("m l J_r J_w", positive=True)  # noqa: E741
    x, y, theta, psi, phi, v = (sp.Function(name)(t) for name in (*NAMES, "v"))
    spins = [theta, theta + psi, theta + phi, theta - phi]
    moments = [m * l**2 - J_r - 2 * J_w, J_r, J_w, J_w]
    turning = sum(J * angle.diff(t) ** 2 for J, angle in zip(moments, spins, strict=True))
    T = (m * (x.diff(t) ** 2 + y.diff(t) ** 2) + turning) / 2
    momenta = [T.diff(c.diff(t)) for c in (x, y, theta)]  # T depends on no coordinate

    back, tangent = -2 * l * sp.cos(phi) ** 2, sp.sin(phi) / sp.cos(phi)
    free = [back * sp.cos(theta), back * sp.sin(theta), 2 * sp.sin(phi) * sp.cos(phi)]
    speeds = [v * sp.cos(theta), v * sp.sin(theta), -v * tangent / l]
    rolling = {c.diff(t): s for c, s in zip((x, y, theta), speeds, strict=True)}
    rolled = {rate.diff(t): speed.diff(t) for rate, speed in rolling.items()}
    force = sum(p.diff(t) * direction for p, direction in zip(momenta, free, strict=True))

    p = 2 * J_r * sp.sin(phi) * sp.cos(phi) * psi.diff(t) - 2 * m * l * v
    pumped = 2 * J_r * sp.cos(phi) ** 2 * phi.diff(t) * psi.diff(t)
    p_dot = pumped - tangent * phi.diff(t) * p
    return sp.simplify(sp.expand(force.subs(rolled).subs(rolling) - p.diff(t) + p_dot))


# Motions


@dataclass(frozen=True)
class Gait:
    """psi = A sin(w_psi t), phi = A sin(w_phi t), from rest in the sense p(0) = 0."""

    w_psi: float
    w_phi: float
    amplitude: float = 0.7

    def shape(self, t: float) -> Array:
        """Return (psi, phi) and their first and second derivatives, shape (3, 2)."""
        w = np.array([self.w_psi, self.w_phi])
        sine, cosine = np.sin(w * t), np.cos(w * t)
        return self.amplitude * np.array([sine, w * cosine, -(w**2) * sine])


def follow(gait: Gait, t: Array, board: Board) -> Array:
    """(x, y, theta, p) at the times ``t``, shape (len(t), 4), by the momentum equation alone."""

    def slope(time: float, state: Array) -> Array:
        (psi, phi), (psi_dot, phi_dot), _ = gait.shape(time)
        p_dot = momentum_rate(state[3], phi, psi_dot, phi_dot, board)
        whole = np.array([*state[:3], psi, phi, state[3], psi_dot, phi_dot])
        return np.array([*rates(whole, board)[:3], p_dot])

    span = (float(t[0]), float(t[-1]))
    run = solve_ivp(slope, span, np.zeros(4), "DOP853", t_eval=t, rtol=1e-12, atol=1e-13)
    return np.asarray(run.y.T)


def swing(pose: Array, phi: float, turned: float, board: Board) -> Array:
    """Pose (x, y, theta) after the rotor has turned by ``turned`` with the steering held.

    From rest p stays 0, so the board turns by -(J_r / m l^2) sin^2 phi of it, about the point
    l cot phi to its right where the axles meet.
    """
    theta = pose[2] - board.J_r / (board.m * board.l**2) * np.sin(phi) ** 2 * turned
    across = np.array([np.sin(theta) - np.sin(pose[2]), np.cos(pose[2]) - np.cos(theta)])
    return np.array([*(pose[:2] - board.l / np.tan(phi) * across), theta])
