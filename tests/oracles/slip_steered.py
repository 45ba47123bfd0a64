"""A vehicle with four driven wheels that steers by skidding, by hand.

SI units. The body frame sits midway between the left and the right contacts: x ahead, y to the
left. ``a`` ahead of its origin O is the front axle, ``b`` behind it the rear one; ``c`` to either
side are the wheels. Everywhere the wheels are front left, front right, rear left, rear right.

V = (v_x, v_y, omega): velocity of O in the body frame in [m/s], turn to the left in [rad/s].
w = rates of the four wheels in [rad/s], positive where they drive ahead.
s_i = (v_x - omega y_i - r w_i, v_y + omega x_i): velocity of the rubber over the ground in [m/s].
P(V, w) = sum mu_i N_i |s_i|: what friction turns into heat, in [W]; convex in V.

State: (x, y, theta, v_x, v_y, omega, w_1, ..., w_4). Inputs: the torques at the four wheels.

The ground is a rigid plane and the four contacts stand on equal vertical springs, so their loads
are those of a plate at rest: nothing shifts while the vehicle brakes, climbs or turns.

Sources:
    Alexander, Maddocks, On the kinematics of wheeled mobile robots, IJRR 8(5), 1989: slow motion
        under Coulomb friction dissipates least.
    Murphey, Burdick, The power dissipation method and kinematic reducibility of multiple-model
        robotic systems, IEEE T-RO 22(4), 2006: which contacts hold, and which slip.
    Boyd, Vandenberghe, Convex Optimization, 2004, section 5.9: duals of sums of norms.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

Array = NDArray[np.float64]

STATES = ("x", "y", "theta", "v_x", "v_y", "omega", "w_fl", "w_fr", "w_rl", "w_rr")
CONTROLS = ("front_left", "front_right", "rear_left", "rear_right")


@dataclass(frozen=True)
class SkidVehicle:
    """Four wheels of radius ``r`` under a chassis; ``m`` and ``I_z`` are those of the whole.

    Attributes:
        m: Mass in [kg].
        I_z: Yaw inertia about the centre of mass in [kg m^2].
        I_w: One wheel about its axle in [kg m^2].
        a: Front axle ahead of O in [m].
        b: Rear axle behind O in [m].
        c: Half of the track in [m].
        r: Radius of the wheels in [m].
        ahead: Centre of mass ahead of O in [m].
        left: Centre of mass to the left of O in [m].
        mu: Coefficients of friction of the four contacts.
        g: Gravity in [m/s^2].
    """

    m: float = 50.0
    I_z: float = 3.0
    I_w: float = 0.05
    a: float = 0.25
    b: float = 0.25
    c: float = 0.3
    r: float = 0.12
    ahead: float = 0.0
    left: float = 0.0
    mu: tuple[float, float, float, float] = (0.7, 0.7, 0.7, 0.7)
    g: float = 9.81

    @property
    def contacts(self) -> Array:
        """Where the wheels touch the ground, in the body frame in [m], shape (4, 2)."""
        return np.array(
            [[self.a, self.c], [self.a, -self.c], [-self.b, self.c], [-self.b, -self.c]]
        )

    @property
    def grips(self) -> Array:
        """Largest friction mu_i N_i of the four contacts in [N], shape (4,)."""
        return np.array(self.mu) * loads(self)


def sides(left: float, right: float) -> Array:
    """Return the four rates, or torques, of a vehicle whose sides are chained, shape (4,)."""
    return np.array([left, right, left, right])


# Loads


def loads(vehicle: SkidVehicle) -> Array:
    """Return the normal forces in [N], shape (4,), of equal springs under a rigid plate.

    A plate sinks by z + alpha x + beta y. Measured from the contacts' centroid the sums of x, y
    and x y over a rectangle vanish, so that each of the three balances gives one unknown.
    """
    spread = vehicle.contacts - vehicle.contacts.mean(axis=0)
    arm = np.array([vehicle.ahead, vehicle.left]) - vehicle.contacts.mean(axis=0)
    shares = 1 / 4 + spread @ (arm / (spread**2).sum(axis=0))
    return np.asarray(vehicle.m * vehicle.g * shares)


def loads_of_least_energy(vehicle: SkidVehicle) -> Array:
    """Return the same forces, shape (4,), as those that store the least energy in the springs.

    Of all loads that balance weight and moments these have the least sum of squares
    (Castigliano), which is what the pseudo-inverse finds.
    """
    balance = np.vstack([np.ones(4), vehicle.contacts.T])
    weight = vehicle.m * vehicle.g * np.array([1, vehicle.ahead, vehicle.left])
    return np.asarray(np.linalg.lstsq(balance, weight, rcond=None)[0])


# Slip and heat


def slip_jacobian(vehicle: SkidVehicle) -> Array:
    """Return A of s_i = A_i V - (r w_i, 0), shape (4, 2, 3)."""
    A = np.zeros((4, 2, 3))
    A[:, 0, 0] = A[:, 1, 1] = 1
    A[:, 0, 2], A[:, 1, 2] = -vehicle.contacts[:, 1], vehicle.contacts[:, 0]
    return A


def rubber_velocity(rates: Array, vehicle: SkidVehicle) -> Array:
    """Return (r w_i, 0) in [m/s], shape (4, 2): how fast the axle leaves the rubber behind."""
    return np.stack([vehicle.r * np.asarray(rates), np.zeros(4)], axis=1)


def slip_velocities(V: Array, rates: Array, vehicle: SkidVehicle) -> Array:
    """Return s in [m/s], shape (4, 2), in the body frame."""
    return np.asarray(slip_jacobian(vehicle) @ V - rubber_velocity(rates, vehicle))


def dissipation(V: Array, rates: Array, vehicle: SkidVehicle) -> float:
    """Return P = sum mu N |s| in [W]."""
    slips = np.linalg.norm(slip_velocities(V, rates, vehicle), axis=1)
    return float(vehicle.grips @ slips)


# Least dissipation


@dataclass(frozen=True)
class LeastDissipation:
    """A body velocity of least dissipation, and the proof.

    Attributes:
        V: Body velocity (v_x, v_y, omega), shape (3,).
        P: Its dissipation in [W]; no less than the least one.
        bound: What no body velocity falls below, in [W].
        forces: Forces of the wheels on the ground in [N], shape (4, 2), balanced and within the
            friction disks, from which the bound follows.
    """

    V: Array
    P: float
    bound: float
    forces: Array

    @property
    def gap(self) -> float:
        """By how much P may exceed the least dissipation, in [W]."""
        return self.P - self.bound


def least_by_grid(rates: Array, vehicle: SkidVehicle, precision: float = 1e-7) -> Array:
    """Return argmin_V P, shape (3,), by grids within grids.

    What a convex function reaches at best over some of its arguments is convex in the others. So a
    grid over turns closes in on its best point, where each turn takes its best speed ahead, and
    each of those its best speed across. Turns count as speeds at the arm ``c``.

    Args:
        precision: Width of the last grids in [m/s]. P is right to its order; V, where P is smooth,
            to its square root.
    """
    A, p, grips = slip_jacobian(vehicle), rubber_velocity(rates, vehicle), vehicle.grips
    arms = np.array([1, 1, 1 / vehicle.c])
    width = 4 * vehicle.r * float(np.abs(rates).max()) + precision

    def heat(turn: Array, ahead: Array, across: Array) -> Array:
        V = np.stack(np.broadcast_arrays(ahead, across, turn), axis=-1) * arms
        s = np.tensordot(V, A, axes=(-1, 2)) - p
        return np.asarray(np.hypot(s[..., 0], s[..., 1]) @ grips)

    def best_across(turn: Array, ahead: Array) -> Array:
        def value(v: Array) -> Array:
            return heat(turn[..., None], ahead[..., None], v)

        return _close_in(value, turn.shape, width, precision)

    def best_ahead(turn: Array) -> Array:
        def value(v: Array) -> Array:
            turns = np.broadcast_to(turn[..., None], v.shape)
            return heat(turns, v, best_across(turns, v))

        return _close_in(value, turn.shape, width, precision)

    def over_turns(turn: Array) -> Array:
        ahead = best_ahead(turn)
        return heat(turn, ahead, best_across(turn, ahead))

    turn = _close_in(over_turns, (), width, precision)
    ahead = best_ahead(turn)
    return np.asarray(arms * np.array([ahead, best_across(turn, ahead), turn]))


def _close_in(
    value: Callable[[Array], Array], shape: tuple[int, ...], width: float, precision: float
) -> Array:
    """Return where convex functions of one argument are least, as many as ``shape`` has entries.

    The least lies between the neighbours of a grid's best point, which are the next grid's ends.
    """
    ticks, centre = np.linspace(-1, 1, 11), np.zeros(shape)
    while True:
        points = centre[..., None] + width * ticks
        best = value(points).argmin(axis=-1)
        centre = np.take_along_axis(points, best[..., None], axis=-1)[..., 0]
        if width < precision:
            return centre
        width *= float(ticks[1] - ticks[0])


def least_by_newton(rates: Array, vehicle: SkidVehicle, eps: float = 1e-8) -> LeastDissipation:
    """Return argmin_V P with a bound from below, by Newton's method on softened norms.

    With |s| softened to sqrt(|s|^2 + eps^2) the forces f_i = mu_i N_i s_i / sqrt(|s_i|^2 + eps^2)
    lie within their disks; at the softened minimum sum A_i^T f_i = 0. For such forces and any V
    P(V) >= sum f_i . s_i(V) = -sum f_i . (r w_i, 0), which is the bound. It is at most
    eps sum mu_i N_i below P. ``eps`` sinks by steps of two from the speed of the wheels.
    """
    A, p, grips = slip_jacobian(vehicle), rubber_velocity(rates, vehicle), vehicle.grips
    V, soft = np.zeros(3), max(float(np.abs(p).max()), eps)
    while True:
        V = _soft_minimum(V, soft, A, p, grips)
        if soft <= eps:
            break
        soft = max(soft / 2, eps)
    s = A @ V - p
    forces = (grips / np.sqrt((s**2).sum(axis=1) + soft**2))[:, None] * s
    forces = _balanced(forces, A)
    forces /= max(1.0, float((np.linalg.norm(forces, axis=1) / grips).max()))
    return LeastDissipation(V, dissipation(V, rates, vehicle), float(-(forces * p).sum()), forces)


def _soft_minimum(V: Array, soft: float, A: Array, p: Array, grips: Array) -> Array:
    """Return the minimum of sum mu N sqrt(|s|^2 + soft^2), from V by damped Newton steps."""

    def slopes(at: Array) -> tuple[Array, Array]:
        s = A @ at - p
        lengths = np.sqrt((s**2).sum(axis=1) + soft**2)
        n = s / lengths[:, None]
        bends = (np.eye(2) - n[:, :, None] * n[:, None, :]) * (grips / lengths)[:, None, None]
        hessian = np.einsum("ijk,ijl,ilm->km", A, bends, A)
        return np.einsum("i,ijk,ij->k", grips, A, n), np.asarray(hessian)

    for _ in range(100):
        gradient, hessian = slopes(V)
        step, share = -np.linalg.solve(hessian, gradient), 1.0
        while share > 1e-6 and abs(slopes(V + share * step)[0] @ step) > abs(gradient @ step):
            share /= 2  # values would drown in rounding before slopes do
        V = V + share * step
        if np.abs(step).max() < 1e-4 * soft:  # the next step would be its square
            break
    return V


def _balanced(forces: Array, A: Array) -> Array:
    """Return the nearest forces, shape (4, 2), that add up to no force and no moment."""
    rows = A.reshape(8, 3)
    excess = np.linalg.lstsq(rows.T, rows.T @ forces.ravel(), rcond=None)[0]
    return np.asarray(forces - excess.reshape(4, 2))


def least_by_polygons(
    rates: Array, vehicle: SkidVehicle, corners: int = 360
) -> tuple[float, float]:
    """Return what the least dissipation in [W] lies between, by one linear program.

    The norm is at least its greatest projection on ``corners`` directions, and at most that over
    cos(pi / corners). Of the unknowns (V, t_1, ..., t_4) each t_i exceeds all projections of s_i.
    """
    A, p, grips = slip_jacobian(vehicle), rubber_velocity(rates, vehicle), vehicle.grips
    angles = 2 * np.pi * np.arange(corners) / corners
    fan = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rows = [np.hstack([fan @ A[i], -np.outer(np.ones(corners), np.eye(4)[i])]) for i in range(4)]
    limits = np.concatenate([fan @ p[i] for i in range(4)])
    cost = np.concatenate([np.zeros(3), grips])
    free = [(None, None)] * 7
    found = linprog(cost, A_ub=np.vstack(rows), b_ub=limits, bounds=free, method="highs")
    return float(found.fun), float(found.fun / np.cos(np.pi / corners))


# Closed forms


def rotation_centre(V: Array) -> Array:
    """Return the point (x, y) of the body plane that stands still in [m]; infinite at no turn."""
    if V[2] == 0:
        return np.array([np.inf, np.inf])
    return np.array([-V[1] / V[2], V[0] / V[2]])


def axle_twist(rates: Array, axle: str, vehicle: SkidVehicle) -> Array:
    """Return the V, shape (3,), at which the ``front`` or the ``rear`` pair does not slip at all.

    Two wheels of an axle fix the speed and the turn; the axle's midpoint moves straight ahead.
    """
    left, right = rates[:2] if axle == "front" else rates[2:]
    place = vehicle.a if axle == "front" else -vehicle.b
    turn = vehicle.r * (right - left) / (2 * vehicle.c)
    return np.array([vehicle.r * (left + right) / 2, -place * turn, turn])


def snap_ratio(vehicle: SkidVehicle) -> float:
    """Return how many times an axle must grip the other for it not to slip in any turn.

    Sides chained, grips equal on the left and on the right. Where the strong axle holds, the
    other slips straight across with G_w per wheel. Balance across asks the same G_w of each
    strong wheel, and the moment about the strong axle another G_w (a + b) / c along it:
    G_s >= G_w sqrt(1 + ((a + b) / c)^2), whatever the rates.
    """
    return float(np.hypot(1, (vehicle.a + vehicle.b) / vehicle.c))


def snap_offset(vehicle: SkidVehicle) -> float:
    """Return how far ahead of O in [m] the centre of mass must be for the front axle to hold.

    Equal friction everywhere; N_f / N_r = (b + ahead) / (a - ahead) reaches ``snap_ratio``.
    """
    ratio = snap_ratio(vehicle)
    return float((ratio * vehicle.a - vehicle.b) / (1 + ratio))


def turn_on_the_spot(rate: float, vehicle: SkidVehicle) -> tuple[float, float]:
    """Return turn in [rad/s] and least dissipation in [W] for sides at -rate and rate.

    Equal loads and friction, a = b: all slips equal sqrt((r w - c omega)^2 + (a omega)^2), least
    at omega = c r w / (a^2 + c^2).
    """
    a, c, rim = vehicle.a, vehicle.c, vehicle.r * rate
    grip = float(vehicle.grips.sum())
    return c * rim / (a**2 + c**2), grip * abs(rim) * a / float(np.hypot(a, c))


# Dynamics


def friction(V: Array, rates: Array, vehicle: SkidVehicle, eps: float) -> Array:
    """Return forces of the ground on the wheels in [N], shape (4, 2), in the body frame.

    Coulomb friction, softened below the slip ``eps`` in [m/s]: -mu N s / sqrt(|s|^2 + eps^2).
    """
    s = slip_velocities(V, rates, vehicle)
    return np.asarray(-(vehicle.grips / np.sqrt((s**2).sum(axis=1) + eps**2))[:, None] * s)


def friction_heat(V: Array, rates: Array, vehicle: SkidVehicle, eps: float) -> float:
    """Return what the softened friction turns into heat, in [W]; at most eps sum mu N below P."""
    s = slip_velocities(V, rates, vehicle)
    return float(-(friction(V, rates, vehicle, eps) * s).sum())


def body_mass_matrix(vehicle: SkidVehicle) -> Array:
    """Return M of T = V M V / 2, shape (3, 3), without the wheels' spins."""
    m, d, e = vehicle.m, vehicle.ahead, vehicle.left
    about_O = vehicle.I_z + m * (d**2 + e**2)
    return np.array([[m, 0, -m * e], [0, m, m * d], [-m * e, m * d, about_O]])


def body_acceleration(
    V: Array, rates: Array, vehicle: SkidVehicle, eps: float, inertia: float = 1.0
) -> Array:
    """Return V_dot, shape (3,), by Newton and Euler about O for the rates at hand.

    Seen from the body, the centre of mass (d, e) accelerates by
    (v_x_dot - omega v_y - omega_dot e - omega^2 d, v_y_dot + omega v_x + omega_dot d - omega^2 e).

    Args:
        inertia: Share of mass and yaw inertia that resists, while the loads stay. As it goes to
            zero, V follows argmin_V P: forces that balance are those of the dual.
    """
    m, d, e, (v_x, v_y, turn) = vehicle.m, vehicle.ahead, vehicle.left, V
    forces = friction(V, rates, vehicle, eps)
    pull = np.einsum("ijk,ij->k", slip_jacobian(vehicle), forces)
    known = m * np.array([-turn * v_y - turn**2 * d, turn * v_x - turn**2 * e])
    bias = np.array([*known, d * known[1] - e * known[0]])
    return np.asarray(np.linalg.solve(body_mass_matrix(vehicle), pull / inertia - bias))


def derivative(x: Array, u: Array, vehicle: SkidVehicle, eps: float = 1e-3) -> Array:
    """Return x_dot, shape (10,); ``u`` are the torques in [N m], shape (4,).

    Each wheel: I_w w_dot = u - r f_x with the ground's force f_x along the wheel.
    """
    V, rates = x[3:6], x[6:]
    c, s = np.cos(x[2]), np.sin(x[2])
    place = [c * V[0] - s * V[1], s * V[0] + c * V[1], V[2]]
    spins = (u - vehicle.r * friction(V, rates, vehicle, eps)[:, 0]) / vehicle.I_w
    return np.concatenate([place, body_acceleration(V, rates, vehicle, eps), spins])


def kinetic_energy(x: Array, vehicle: SkidVehicle) -> float:
    """Return T in [J]: the whole at its centre of mass, its yaw, the wheels' spins."""
    v_x, v_y, turn = x[3:6]
    speed = (v_x - turn * vehicle.left) ** 2 + (v_y + turn * vehicle.ahead) ** 2
    spins = vehicle.I_w * (x[6:] ** 2).sum()
    return float(vehicle.m * speed + vehicle.I_z * turn**2 + spins) / 2


def energy_balance(x: Array, u: Array, vehicle: SkidVehicle, eps: float = 1e-3) -> float:
    """Return T_dot - (u . w - heat) in [W], which is zero.

    T is quadratic in the velocities, so the central difference over a unit step is exact.
    """
    x_dot = derivative(x, u, vehicle, eps)
    T_dot = (kinetic_energy(x + x_dot, vehicle) - kinetic_energy(x - x_dot, vehicle)) / 2
    return float(T_dot - u @ x[6:] + friction_heat(x[3:6], x[6:], vehicle, eps))
