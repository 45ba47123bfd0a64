"""Two wheeled vehicles by hand, and the shortest paths of a car between two poses.

SI units. Poses are (x, y, heading); turns to the left are positive.

Differential drive: x = (x, y, psi, phi_l, phi_r, phi_l_dot, phi_r_dot), u = (left, right), at the
midpoint of the axle, above which sits the centre of mass.
Car: x = (x, y, psi, delta, phi, delta_dot, phi_dot), u = (drive, steer), at the midpoint of the
rear axle; one wheel stands for each axle.

Sources:
    Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, chapter 6:
        Lagrange's equations with multipliers.
    Kane, Levinson, Dynamics: Theory and Applications, 1985: inertia forces times partial
        velocities.
    Dubins, On curves of minimal length with a constraint on average curvature, American J.
        Mathematics 79, 1957.
    Reeds, Shepp, Optimal paths for a car that goes both forwards and backwards, Pacific J.
        Mathematics 145, 1990: the 48 words that suffice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Any, Protocol

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import quad

Array = NDArray[np.float64]
Pose = Sequence[float]  # x, y in [m], heading in [rad]

DRIVE_STATES = ("x", "y", "psi", "phi_l", "phi_r", "phi_l_dot", "phi_r_dot")
DRIVE_CONTROLS = ("left", "right")
CAR_STATES = ("x", "y", "psi", "delta", "phi", "delta_dot", "phi_dot")
CAR_CONTROLS = ("drive", "steer")


# Differential drive


@dataclass(frozen=True)
class DiffDrive:
    """Two driven wheels of radius ``r``, ``b`` apart; ``m`` and ``I_z`` are those of the whole."""

    m: float = 9.0
    I_z: float = 0.16
    I_w: float = 0.012
    r: float = 0.0975
    b: float = 0.33
    c_w: float = 0.02

    @property
    def mass(self) -> float:
        """What resists the speed, in [kg]: m v_dot + 2 I_w phi_ddot / r with phi_dot = v / r."""
        return self.m + 2 * self.I_w / self.r**2

    @property
    def inertia(self) -> float:
        """What resists the turn, in [kg m^2]: the wheels spin by b / (2 r) per radian."""
        return self.I_z + self.I_w * self.b**2 / (2 * self.r**2)

    @property
    def drags(self) -> tuple[float, float]:
        """Drag per speed in [N s/m] and per turn in [N m s]: c_w phi_dot at both wheels."""
        return 2 * self.c_w / self.r**2, self.c_w * self.b**2 / (2 * self.r**2)

    def thrust(self, u: Array) -> tuple[float, float]:
        """Force in [N] along the heading and moment in [N m] of the torques (left, right)."""
        return float(u[0] + u[1]) / self.r, self.b * float(u[1] - u[0]) / (2 * self.r)

    def twist(self, x: Array) -> tuple[float, float]:
        """Speed in [m/s] and turn in [rad/s] of a state."""
        left, right = x[5:7]
        return float(self.r * (left + right) / 2), float(self.r * (right - left) / self.b)

    def wheels(self, speed: Any, turn: Any) -> tuple[Any, Any]:
        """Rates of the left and the right wheel: the inverse of ``twist``."""
        return (speed - self.b * turn / 2) / self.r, (speed + self.b * turn / 2) / self.r


def drive_derivative(x: Array, u: Array, robot: DiffDrive) -> Array:
    """Return x_dot, shape (7,), by Newton for the whole and Euler for each wheel."""
    (force, moment), (speed, turn) = robot.thrust(u), robot.twist(x)
    along, about = robot.drags
    rates = (force - along * speed) / robot.mass, (moment - about * turn) / robot.inertia
    place = [speed * np.cos(x[2]), speed * np.sin(x[2]), turn]
    return np.array([*place, *x[5:7], *robot.wheels(*rates)])


def drive_by_multipliers(x: Array, u: Array, robot: DiffDrive) -> Array:
    """Return (phi_l_ddot, phi_r_ddot) from five coordinates and three multipliers."""
    c, s = np.cos(x[2]), np.sin(x[2])
    v, turn = robot.twist(x)
    w = np.array(
        [
            [-s, c, 0, 0, 0],  # no sideslip
            [c, s, -robot.b / 2, -robot.r, 0],
            [c, s, robot.b / 2, 0, -robot.r],
        ]
    )
    # w_dot q_dot with q_dot = (v c, v s, turn, ...): only the sideslip's row is not zero.
    M = np.diag([robot.m, robot.m, robot.I_z, robot.I_w, robot.I_w])
    applied = np.concatenate([np.zeros(3), u - robot.c_w * x[5:7]])
    return constrained(M, w, applied, np.array([-v * turn, 0, 0]))[3:]


def constrained(M: Array, w: Array, applied: Array, w_dot_q_dot: Array) -> Array:
    """Return q_ddot from M q_ddot = applied + w^T lambda and w q_ddot + w_dot q_dot = 0."""
    rows, columns = w.shape
    system = np.block([[M, -w.T], [w, np.zeros((rows, rows))]])
    solution = np.linalg.solve(system, np.concatenate([applied, -w_dot_q_dot]))
    return np.asarray(solution[:columns])


def drive_energy(x: Array, robot: DiffDrive) -> float:
    """Kinetic energy in [J]."""
    speed, turn = robot.twist(x)
    return (robot.m * speed**2 + robot.I_z * turn**2 + robot.I_w * float(x[5:7] @ x[5:7])) / 2


def constant_torque_motion(start: Array, u: Array, t: float, robot: DiffDrive) -> Array:
    """State after ``t`` seconds, shape (7,): exponentials, and a quadrature for the place."""
    (force, moment), (along, about) = robot.thrust(u), robot.drags
    v_0, turn_0 = robot.twist(start)

    def moved(tau: float) -> tuple[float, float, float, float]:
        speed, way = relaxation(v_0, force / robot.mass, along / robot.mass, tau)
        turn, angle = relaxation(turn_0, moment / robot.inertia, about / robot.inertia, tau)
        return speed, way, turn, angle

    def slope(tau: float, direction: Callable[[float], float]) -> float:
        speed, _, _, angle = moved(tau)
        return speed * direction(start[2] + angle)

    settings: dict[str, Any] = {"epsabs": 1e-12, "epsrel": 1e-12, "limit": 400}
    shift = [quad(slope, 0, t, args=(f,), **settings)[0] for f in (np.cos, np.sin)]
    speed, way, turn, angle = moved(t)
    moves = np.array([*shift, angle, *robot.wheels(way, angle)])
    return np.concatenate([start[:5] + moves, robot.wheels(speed, turn)])


def relaxation(v_0: float, a: float, k: float, t: float) -> tuple[float, float]:
    """Return v and its integral at time t for v_dot = a - k v."""
    if k == 0:
        return v_0 + a * t, v_0 * t + a * t**2 / 2
    faded = -np.expm1(-k * t) / k  # the integral of exp(-k t)
    return v_0 + (a - k * v_0) * faded, v_0 * faded + a * (t - faded) / k


def flat_drive(path: Sequence[Any], t: Any, robot: DiffDrive) -> Callable[[float], Array]:
    """Return (x, y, psi, phi_l_dot, phi_r_dot, left, right) over time, from the axle's midpoint.

    Args:
        path: Midpoint (x, y) as expressions in ``t``, three times differentiable, never at rest.
        t: Time in [s].
    """
    x_dot, y_dot = (sp.diff(p, t) for p in path)
    speed, psi = sp.sqrt(x_dot**2 + y_dot**2), sp.atan2(y_dot, x_dot)
    turn = sp.diff(psi, t)
    along, about = robot.drags
    force = robot.mass * sp.diff(speed, t) + along * speed
    moment = robot.inertia * sp.diff(turn, t) + about * turn
    # Each side gives half the force, and a share of the moment at the arm b / 2.
    torques = [robot.r * (force / 2 - side * moment / robot.b) for side in (1, -1)]
    evaluate = sp.lambdify(t, [*path, psi, *robot.wheels(speed, turn), *torques], cse=True)
    return lambda time: np.array(evaluate(time), dtype=np.float64)


# Car


@dataclass(frozen=True)
class Car:
    """A chassis of mass ``m`` in [kg], ``a`` in [m] ahead of the rear axle, wheelbase ``L``.

    Attributes:
        R: Radius of the rear wheels in [m].
        I_z: Chassis about its centre of mass in [kg m^2].
        I_w: Rear axle about itself in [kg m^2].
        J_s: Steering about the vertical in [kg m^2]; it has no mass.
        c_d: Drag of the axle in [N m s].
        c_s: Drag of the steering in [N m s].
    """

    m: float = 1200.0
    L: float = 2.7
    R: float = 0.31
    I_z: float = 1900.0
    a: float = 1.2
    I_w: float = 2.5
    J_s: float = 4.0
    c_d: float = 3.0
    c_s: float = 6.0


def car_derivative(x: Array, u: Array, car: Car) -> Array:
    """Return x_dot, shape (7,), from inertia forces times partial velocities.

    With k = tan(delta) / L, speed v = R phi_dot and turn w = k v, the rear axle accelerates by
    (v_dot, v w) along and across the car, the centre of mass by (v_dot - a w^2, v w + a w_dot);
    the partial velocities by v are (1, a k) and k. Its centripetal terms cancel, since k v = w.
    The steering obeys J_s (w_dot + delta_ddot) = steer - c_s delta_dot.
    """
    psi, delta, delta_dot, phi_dot = x[[2, 3, 5, 6]]
    v, k = car.R * phi_dot, np.tan(delta) / car.L
    k_dot = delta_dot / (car.L * np.cos(delta) ** 2)
    turning = car.m * car.a**2 + car.I_z
    steering = u[1] - car.c_s * delta_dot
    axle = u[0] - car.c_d * phi_dot - car.R * k * (steering + turning * k_dot * v)
    phi_ddot = axle / (car.I_w + car.R**2 * (car.m + turning * k**2))
    delta_ddot = steering / car.J_s - k * car.R * phi_ddot - k_dot * v
    place = [v * np.cos(psi), v * np.sin(psi), k * v]
    return np.array([*place, delta_dot, phi_dot, delta_ddot, phi_ddot])


def car_velocity(x: Array, car: Car) -> Array:
    """Return q_dot of (x, y, psi, delta, phi), shape (5,)."""
    return car_derivative(x, np.zeros(2), car)[:5]


def car_energy(x: Array, car: Car) -> float:
    """Kinetic energy in [J]: chassis about its centre of mass, steering and axle."""
    turn, delta_dot, phi_dot = car_velocity(x, car)[2:]
    forward, sideways = car.R * phi_dot, car.a * turn
    chassis = car.m * (forward**2 + sideways**2) + car.I_z * turn**2
    return float(chassis + car.J_s * (turn + delta_dot) ** 2 + car.I_w * phi_dot**2) / 2


def car_by_multipliers(x: Array, u: Array, car: Car) -> Array:
    """Return (delta_ddot, phi_ddot) from Lagrange's equations of all five coordinates."""
    q, q_dot = x[:5], car_velocity(x, car)
    M, bias, w, w_dot_q_dot = (np.array(part, dtype=float) for part in _lagrange(car)(*q, *q_dot))
    drags = np.array([0, 0, 0, car.c_s, car.c_d]) * q_dot
    applied = np.array([0, 0, 0, u[1], u[0]]) - drags - bias.ravel()
    return constrained(M, w, applied, w_dot_q_dot.ravel())[3:]


def flat_car(path: Sequence[Any], t: Any, car: Car) -> Callable[[float], Array]:
    """Return (x, y, psi, delta, delta_dot, phi_dot, drive, steer) over time, driving forwards.

    The path's curvature k = tan(delta) / L sets the steering. Newton and Euler for chassis and
    steering, in speed v and turn w = k v, along the partial velocities of v: what the rear wheels
    push with is m v_dot + k (I w_dot + J_s (w_dot + delta_ddot)), I = I_z + m a^2.

    Args:
        path: Midpoint of the rear axle (x, y) as expressions in ``t``, four times differentiable,
            never at rest.
        t: Time in [s].
    """
    x_dot, y_dot = (sp.diff(p, t) for p in path)
    x_ddot, y_ddot = (sp.diff(p, t, 2) for p in path)
    v, psi = sp.sqrt(x_dot**2 + y_dot**2), sp.atan2(y_dot, x_dot)
    w = (x_dot * y_ddot - y_dot * x_ddot) / v**2
    delta = sp.atan(car.L * w / v)
    delta_dot, w_dot = sp.diff(delta, t), sp.diff(w, t)
    turning = (car.I_z + car.m * car.a**2) * w_dot
    steering = car.J_s * (w_dot + sp.diff(delta_dot, t))
    push = car.m * sp.diff(v, t) + w / v * (turning + steering)
    drive = car.R * push + (car.I_w * sp.diff(v, t) + car.c_d * v) / car.R
    state = [*path, psi, delta, delta_dot, v / car.R]
    evaluate = sp.lambdify(t, [*state, drive, steering + car.c_s * delta_dot], cse=True)
    return lambda time: np.array(evaluate(time), dtype=np.float64)


@cache
def _lagrange(car: Car) -> Callable[..., Any]:
    """Return M, M_dot q_dot - dT/dq, w and w_dot q_dot as functions of q and q_dot."""
    q, v = sp.Matrix(sp.symbols("x y psi delta phi")), sp.Matrix(sp.symbols("v:5"))
    _, _, psi, delta, _ = q
    centre = [v[0] - car.a * sp.sin(psi) * v[2], v[1] + car.a * sp.cos(psi) * v[2]]
    chassis = car.m * (centre[0] ** 2 + centre[1] ** 2) + car.I_z * v[2] ** 2
    T = (chassis + car.J_s * (v[2] + v[3]) ** 2 + car.I_w * v[4] ** 2) / 2
    front = [v[0] - car.L * sp.sin(psi) * v[2], v[1] + car.L * sp.cos(psi) * v[2]]
    slips = [
        v[1] * sp.cos(psi) - v[0] * sp.sin(psi),
        front[1] * sp.cos(psi + delta) - front[0] * sp.sin(psi + delta),
        v[0] * sp.cos(psi) + v[1] * sp.sin(psi) - car.R * v[4],
    ]
    momentum, slip = sp.Matrix([T]).jacobian(v), sp.Matrix(slips)
    bias = momentum.jacobian(q) * v - sp.Matrix([T]).jacobian(q).T
    parts = [momentum.jacobian(v), bias, slip.jacobian(v), slip.jacobian(q) * v]
    return sp.lambdify((*q, *v), parts)  # type: ignore[no-any-return]


# Shortest paths


class Motion(Protocol):
    """What ``path_length`` reads of a trajectory."""

    @property
    def x(self) -> Array:
        """States, shape (N+1, nx)."""

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the columns of ``x``."""


def path_length(motion: Motion, names: tuple[str, str, str] = ("x", "y", "psi")) -> float:
    """Length in [m] of the path of a point that moves along its heading, both ways.

    Between two knots the path counts as an arc, a chord times (turn / 2) / sin(turn / 2): exact for
    constant curvature, short by what is driven to and fro between two knots.
    """
    x, y, heading = (motion.x[:, motion.state_names.index(name)] for name in names)
    half = np.diff(heading) / 2
    chords = np.hypot(np.diff(x), np.diff(y))
    return float((chords / np.sinc(half / np.pi)).sum())


@dataclass(frozen=True)
class Piece:
    """A piece of a path with unit radius.

    Attributes:
        turn: 1 to the left, -1 to the right, 0 straight.
        gear: 1 forwards, -1 backwards.
        length: Arc length, at least zero.
    """

    turn: int
    gear: int
    length: float


Word = tuple[Piece, ...]
End = tuple[int, int]  # turn and gear of a first or last arc
# From the distance of the first and the last circle's centres to pieces between these arcs
Middles = Callable[[float], Iterator[Word]]
Family = tuple[End, Middles, End]

BOTH = (1, -1)
CLOSES = 1e-9  # a middle fits if it joins the two circles to this share of the radius


def follow(
    word: Sequence[Piece], place: complex = 0j, heading: float = 0.0
) -> tuple[complex, float]:
    """Return where a path with unit radius ends, and its heading there."""
    for piece in word:
        way = piece.gear * piece.length
        if piece.turn == 0:
            place += way * np.exp(1j * heading)
            continue
        centre = place + 1j * piece.turn * np.exp(1j * heading)
        heading += piece.turn * way
        place = centre - 1j * piece.turn * np.exp(1j * heading)
    return complex(place), float(heading)


def dubins_length(start: Pose, goal: Pose, radius: float) -> float:
    """Length in [m] of the shortest path forwards that turns no tighter than ``radius``."""
    return radius * length_of(dubins_word(start, goal, radius))


def reeds_shepp_length(start: Pose, goal: Pose, radius: float) -> float:
    """Length in [m] of the shortest path, both ways, that turns no tighter than ``radius``."""
    return radius * length_of(reeds_shepp_word(start, goal, radius))


def length_of(word: Word) -> float:
    """Length of a path with unit radius."""
    return sum(piece.length for piece in word)


def dubins_word(start: Pose, goal: Pose, radius: float) -> Word:
    """Return the pieces, with unit radius, of a shortest path forwards."""
    return _shortest(_dubins_families(), start, goal, radius)


def reeds_shepp_word(start: Pose, goal: Pose, radius: float) -> Word:
    """Return the pieces, with unit radius, of a shortest path both ways."""
    return _shortest(_reeds_shepp_families(), start, goal, radius)


def _shortest(families: Sequence[Family], start: Pose, goal: Pose, radius: float) -> Word:
    """Return the shortest of all words of the families that lead from start to goal."""
    there = complex(goal[0] - start[0], goal[1] - start[1]) / radius
    place, heading = there * np.exp(-1j * start[2]), float(goal[2] - start[2])
    words = (word for family in families for word in _words(*family, place, heading))
    return min(words, key=length_of)


def _words(
    first: End, middles: Middles, last: End, place: complex, heading: float
) -> Iterator[Word]:
    """Yield the words of one family from the origin to a pose.

    The first arc only turns the rest about the first circle's centre, the last arc only turns about
    its own. So the middle is what spans the two centres; where it points gives the first arc, and
    what then lacks in heading the last one.
    """
    begin, end = 1j * first[0], place + 1j * last[0] * np.exp(1j * heading)
    for middle in middles(abs(end - begin)):
        span, turned = follow(middle)
        span += 1j * last[0] * np.exp(1j * turned) - begin
        if abs(abs(span) - abs(end - begin)) < CLOSES:
            pointing = _angle(end - begin) - _angle(span)
            arcs = _arc(first, pointing), _arc(last, heading - pointing - turned)
            yield (Piece(*first, arcs[0]), *middle, Piece(*last, arcs[1]))


def _angle(z: complex) -> float:
    """Return the direction of z; of what is zero but for rounding, 0."""
    return float(np.angle(z)) if abs(z) > CLOSES else 0.0


def _arc(end: End, change: float) -> float:
    """Length of an arc, less than a full turn, that changes the heading by ``change``."""
    length = float(np.remainder(end[0] * end[1] * change, 2 * np.pi))
    return 0.0 if length > 2 * np.pi - CLOSES else length


@cache
def _dubins_families() -> tuple[Family, ...]:
    """Return CSC and CCC, all forwards."""
    straight = [((s, 1), _straight(1), (other, 1)) for s, other in product(BOTH, BOTH)]
    return (*straight, *(((s, 1), _bend(-s, 1), (s, 1)) for s in BOTH))


@cache
def _reeds_shepp_families() -> tuple[Family, ...]:
    """Return the 48 words; | is where the gear changes, Cu is as long as the next Cu."""
    families: list[Family] = []
    for s, e, other in product(BOTH, BOTH, BOTH):
        families += [
            ((s, e), _straight(e), (other, e)),  # CSC
            ((s, e), _quarter_straight(-s, -e), (other, -e)),  # C|C(pi/2)SC
            ((s, e), _straight_quarter(other, e), (-other, -e)),  # CSC(pi/2)|C
        ]
    for s, e in product(BOTH, BOTH):
        families += [
            ((s, e), _bend(-s, -e), (s, e)),  # C|C|C
            ((s, e), _bend(-s, e), (s, -e)),  # CC|C
            ((s, e), _bend(-s, -e), (s, -e)),  # C|CC
            ((s, e), _bends_about_a_cusp(-s, e), (-s, -e)),  # CCu|CuC
            ((s, e), _bends_between_cusps(-s, -e), (-s, e)),  # C|CuCu|C
            ((s, e), _quarters(-s, -e), (-s, e)),  # C|C(pi/2)SC(pi/2)|C
        ]
    return tuple(families)


# The middles propose every length that their triangle of centres allows, of circles that turn alike
# or not; ``_words`` keeps what closes.


def _straights(distance: float, less: float) -> list[float]:
    """Lengths along, or across a step of two radii; shortened by ``less``."""
    across = np.sqrt(max(distance**2 - 4, 0))
    return [max(float(long) - less, 0.0) for long in (distance, across) if long > less - CLOSES]


def _straight(gear: int) -> Middles:
    """S."""
    return lambda d: ((Piece(0, gear, u),) for u in _straights(d, 0))


def _quarter_straight(turn: int, gear: int) -> Middles:
    """C(pi/2)S: the quarter moves the centre by one radius, the arc before it by another."""
    quarter = Piece(turn, gear, np.pi / 2)
    return lambda d: ((quarter, Piece(0, gear, u)) for u in _straights(d, 2))


def _straight_quarter(turn: int, gear: int) -> Middles:
    """SC(pi/2): the same from behind."""
    quarter = Piece(turn, gear, np.pi / 2)
    return lambda d: ((Piece(0, gear, u), quarter) for u in _straights(d, 2))


def _quarters(turn: int, gear: int) -> Middles:
    """C(pi/2)SC(pi/2): both quarters shorten the straight piece."""
    one, two = Piece(turn, gear, np.pi / 2), Piece(-turn, gear, np.pi / 2)
    return lambda d: ((one, Piece(0, gear, u), two) for u in _straights(d, 4))


def _bend(turn: int, gear: int) -> Middles:
    """C: both centres are two radii from that of the middle arc, d = 4 sin(u / 2)."""

    def middles(d: float) -> Iterator[Word]:
        u = 2 * float(np.arcsin(min(d / 4, 1)))
        return ((Piece(turn, gear, arc),) for arc in (u, 2 * np.pi - u))

    return middles


def _bends_about_a_cusp(turn: int, gear: int) -> Middles:
    """Cu|Cu: both turn the heading the same way, d = 2 |2 cos u - 1|."""

    def middles(d: float) -> Iterator[Word]:
        arcs = [float(np.arccos(min((2 + sign * d) / 4, 1))) for sign in BOTH if d <= 6]
        return ((Piece(turn, gear, u), Piece(-turn, -gear, u)) for u in arcs)

    return middles


def _bends_between_cusps(turn: int, gear: int) -> Middles:
    """CuCu: an S, d^2 = 20 - 16 cos u."""

    def middles(d: float) -> Iterator[Word]:
        u = float(np.arccos(np.clip((20 - d**2) / 16, -1, 1)))
        return (word for word in [(Piece(turn, gear, u), Piece(-turn, gear, u))])

    return middles
