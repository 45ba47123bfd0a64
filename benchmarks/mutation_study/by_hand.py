"""Equations of motion of the gallery's machines by hand: nothing here asks kinolab how one moves.

Most are those of ``tests/oracles``, which share no code with kinolab, put into the order of a
machine's states. Cranes on one runway, the satellite and the skid-steered robot are written down
here. Of kinolab only the names and the values of parameters are taken, and for the unicycle its
second derivation, by SymPy, which is never compiled.

Sources:
    Wie, Space Vehicle Dynamics and Control, 2nd ed., 2008, section 7.3: a body with wheels.
    Alexander, Maddocks, On the kinematics of wheeled mobile robots, IJRR 8(5), 1989: skidding.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tests.oracles import (
    biped,
    crane,
    falling_disk,
    five_bar,
    helicopter,
    motorcycle,
    pendulum,
    rolling_disk,
    slip_steered,
    snakeboard,
    submarine,
    vehicles,
)

Array: TypeAlias = NDArray[np.float64]
Slope: TypeAlias = Callable[[Array, Array], Array]  # x (nx,), u (nu,) -> x_dot (nx,)
Values: TypeAlias = Mapping[str, float]

LEG, SOLE = 0.45, 0.06  # [m] of the biped's thighs and shanks, and of its round soles


def slope_of(machine: str, values: Values) -> Slope | None:
    """Return x_dot of a machine in the order of kinolab's states; None of one that is not here.

    Args:
        machine: Its name.
        values: Of its parameters.
    """
    made = MACHINES.get(machine)
    return None if made is None else made(dict(values))


def _known(kind: type, values: Values) -> Any:
    """Return an oracle's parameters, of those that it has."""
    named = {entry.name for entry in fields(kind)}
    return kind(**{name: value for name, value in values.items() if name in named})


def _pendulum(values: Values) -> Slope:
    own = _known(pendulum.Pendulum, values)
    return lambda x, u: pendulum.state_derivative(x, u, own)


def _rolling_disk(values: Values) -> Slope:
    own = _known(rolling_disk.Coin, values)
    return lambda x, u: rolling_disk.state_derivative(x, u, own)


def _falling_disk(values: Values) -> Slope:
    m, R, g, k = (values[name] for name in ("m", "R", "g", "k"))
    own = falling_disk.FallingDisk(m=m, R=R, g=g, A=k * m * R**2, B=k * m * R**2 / 2)

    def slope(x: Array, u: Array) -> Array:
        v = R * x[7]
        place = [v * np.cos(x[2]), v * np.sin(x[2])]
        return np.concatenate([place, x[5:8], falling_disk.accelerations(x, u, own)])

    return slope


def _crane(values: Values) -> Slope:
    own = _known(crane.Crane, values)
    return lambda x, u: crane.state_derivative(x, u, own)


def _diff_drive(values: Values) -> Slope:
    own = _known(vehicles.DiffDrive, values)
    return lambda x, u: vehicles.drive_derivative(x, u, own)


def _car(values: Values) -> Slope:
    own = _known(vehicles.Car, values)
    return lambda x, u: vehicles.car_derivative(x, u, own)


def _motorcycle(values: Values) -> Slope:
    own = _known(motorcycle.Motorcycle, values)
    return lambda x, u: motorcycle.state_derivative(x, u, own)


def _helicopter(values: Values) -> Slope:
    def slope(x: Array, u: Array) -> Array:
        turned = helicopter.accelerations(Rotation.from_quat(x[3:7]), x[10:13], u, values)
        return np.concatenate([x[7:10], quaternion_rate(x[3:7], x[10:13]), turned])

    return slope


class _Hull(submarine.Hull):
    """The oracle's hull, whose integrals for the added mass are taken once."""

    @cached_property
    def inertia(self) -> Array:
        """Masses and moments of hull and fluid together, shape (6,)."""
        return submarine.Hull.inertia.fget(self)  # type: ignore[attr-defined, no-any-return]


def _submarine(values: Values) -> Slope:
    hull = _Hull(**values)

    def slope(x: Array, u: Array) -> Array:
        R = Rotation.from_quat(x[3:7]).as_matrix()
        twist = np.append(R.T @ x[7:10], x[10:13])
        pushed = submarine.accelerations(R, twist, u, hull)
        return np.concatenate([x[7:10], quaternion_rate(x[3:7], x[10:13]), pushed])

    return slope


def _five_bar(values: Values) -> Slope:
    own = _known(five_bar.FiveBar, values)

    def slope(x: Array, u: Array) -> Array:
        rates = x[4:6]
        return np.concatenate([own.slopes(x[:2]) @ rates, own.accelerations(x[:2], rates, u)])

    return slope


def _snakeboard(values: Values) -> Slope:
    own = _known(snakeboard.Board, values)
    radius = own.radius

    def slope(x: Array, u: Array) -> Array:
        """Of (x, y, theta, psi, phi, s, psi_dot, phi_dot, s_dot): s is the back wheels' turn."""
        q = np.array([*x[:5], -x[4]])
        psi_dot, phi_dot, s_dot = x[6:9]
        along, across = snakeboard.wheel_rows(q, own)
        rows = np.vstack([across, along[:1]])
        steered = np.array([0.0, 0.0, 0.0, psi_dot, phi_dot, -phi_dot])
        wanted = np.array([0.0, 0.0, radius * s_dot]) - rows @ steered
        q_dot = steered.copy()
        q_dot[:3] = np.linalg.solve(rows[:, :3], wanted)
        q_ddot = snakeboard.multiplier_form(q, q_dot, u, own)
        rolled = along[0] @ q_ddot + snakeboard.rolling_rate(q, q_dot, own) @ q_dot
        return np.array([*q_dot[:5], s_dot, q_ddot[3], q_ddot[4], rolled / radius])

    return slope


def _slip_steered(values: Values) -> Slope:
    """Of (x, y, psi, phi_l, phi_r, x_dot, y_dot, psi_dot, phi_l_dot, phi_r_dot)."""
    mu, drag, eps = (values[name] for name in ("mu", "c_w", "eps"))
    shared = {name: values[name] for name in ("m", "I_z", "I_w", "a", "c", "r", "ahead", "left")}
    own = slip_steered.SkidVehicle(**shared, b=values["a"], mu=(mu,) * 4, g=values["g"])

    def slope(x: Array, u: Array) -> Array:
        c, s = np.cos(x[2]), np.sin(x[2])
        V = np.array([c * x[5] + s * x[6], c * x[6] - s * x[5], x[7]])
        rates = slip_steered.sides(x[8], x[9])
        v_x, v_y, turn = slip_steered.body_acceleration(V, rates, own, eps)
        pushed = np.array([v_x - x[7] * V[1], v_y + x[7] * V[0]])  # of the middle, along the body
        place = [c * pushed[0] - s * pushed[1], s * pushed[0] + c * pushed[1]]
        ground = slip_steered.friction(V, rates, own, eps)[:, 0]
        held = own.r * np.array([ground[0] + ground[2], ground[1] + ground[3]])
        spins = (u - held - drag * x[8:10]) / (2 * own.I_w)
        return np.concatenate([x[5:10], place, [turn], spins])

    return slope


def _two_cranes(values: Values) -> Slope:
    """Of two loads that swing below driven trolleys, each by Newton's law across its rope.

    m l^2 s'' + 2 m l l' s' + m l x'' cos s + m g l sin s = -c_s s', as s grows towards +x.
    """
    m, g, drag = values["m"], values["g"], values["c_s"]

    def swing(l: float, s: float, l_dot: float, s_dot: float, push: float) -> float:  # noqa: E741
        pull = push * np.cos(s) + g * np.sin(s) + 2 * l_dot * s_dot
        return float(-pull / l - drag * s_dot / (m * l**2))

    def slope(x: Array, u: Array) -> Array:
        """Of (x, l, sway) of both, then their rates."""
        one = swing(x[1], x[2], x[7], x[8], u[0])
        two = swing(x[4], x[5], x[10], x[11], u[2])
        return np.concatenate([x[6:12], [u[0], u[1], one, u[2], u[3], two]])

    return slope


def _satellite(values: Values) -> Slope:
    """Of (R, three wheels, the body's rates, the wheels' rates against the bus).

    J is that of the whole with its wheels locked: H = J w + I_w W, H' = H x w, and
    I_w (w' + W') = tau - c W about each wheel's axis. Dry friction is left out.
    """
    J = np.array([values[name] for name in ("J_x", "J_y", "J_z")])
    I_w, drag = values["I_w"], values["c"]
    if values["tau_c"]:
        raise ValueError("dry friction of wheels is not here")

    def slope(x: Array, u: Array) -> Array:
        w, W = x[7:10], x[10:13]
        torque = u - drag * W
        w_dot = (_cross(J * w + I_w * W, w) - torque) / (J - I_w)
        return np.concatenate([quaternion_rate(x[:4], w), W, w_dot, torque / I_w - w_dot])

    return slope


def _cross(a: Array, b: Array) -> Array:
    """Return the product of two vectors (3,), ten times as fast as NumPy, which takes many."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def quaternion_rate(quaternion: Array, w: Array) -> Array:
    """Return the rate of (x, y, z, w) at body rates (3,): half of the product with (w, 0)."""
    n, real = quaternion[:3], quaternion[3]
    return np.append(real * w + _cross(n, w), -n @ w) / 2


MACHINES: dict[str, Callable[[dict[str, float]], Slope]] = {
    "pendulum": _pendulum,
    "rolling_disk": _rolling_disk,
    "falling_disk": _falling_disk,
    "crane": _crane,
    "diff_drive": _diff_drive,
    "car": _car,
    "motorcycle": _motorcycle,
    "helicopter": _helicopter,
    "submarine": _submarine,
    "five_bar": _five_bar,
    "snakeboard": _snakeboard,
    "slip_steered": _slip_steered,
    "two_cranes": _two_cranes,
    "satellite": _satellite,
}


def forces_of(machine: str, values: Values) -> Slope | None:
    """Return constraint forces as a function of state and inputs, in order; None if unknown."""
    if machine != "rolling_disk":
        return None
    own = _known(rolling_disk.Coin, values)
    # along the heading and to its left; the constraints are that it does not slip, and rolls
    return lambda x, u: rolling_disk.contact_force(x, u, own)[::-1]


def closed(machine: str, values: Values, x: Array) -> Array:
    """Return a state whose dependent coordinates follow from the others in closed form."""
    if machine != "five_bar":
        return x
    return np.concatenate([_known(five_bar.FiveBar, values).angles(x[:2]), x[4:]])


def walked(x: Array, u: Array, duration: float, *, lands: bool = True) -> Array:
    """Return the biped's state after a while under held rates; feet that come down change roles.

    Of (x, z, place, lean, hip and knee to the left, to the right, mode); mode 0 stands on the left
    foot. In the oracle's words the legs turn against the torso's lean, and soles are round.

    Args:
        x: State, shape (9,).
        u: Rates of lean and joints in [rad/s], shape (5,).
        duration: In [s].
        lands: Whether a foot that comes down is noticed.
    """
    sides: tuple[biped.Side, biped.Side] = ("left", "right")
    robot = biped.Biped(h=0.0, L_1=LEG, L_2=LEG, sense=-1)
    turn = np.array([1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0])
    x, left, own = np.array(x, dtype=float), duration, [0, 1, 3, 4, 5, 6, 7]
    while True:
        side = sides[round(x[8])]
        other, rates = biped.OTHER[side], u * turn[2:]

        def slope(_: float, q: Array, side: Any = side, rates: Array = rates) -> Array:
            return np.asarray(biped.stance_rates(q, rates, side, robot))

        def height(_: float, q: Array, other: Any = other) -> float:
            return float(biped.foot_place(q, other, robot)[1] - SOLE)

        height.terminal, height.direction = True, -1  # type: ignore[attr-defined]
        run = solve_ivp(
            slope, (0.0, left), x[own] * turn, "DOP853",
            rtol=1e-11, atol=1e-12, events=height if lands else None,
        )  # fmt: skip
        q = run.y[:, -1]
        x[own] = q * turn
        if run.status != 1:
            return x
        x[2], x[8] = biped.foot_place(q, other, robot)[0], float(sides.index(other))
        left -= float(run.t[-1])
