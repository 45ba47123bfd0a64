"""The overhead crane by Newton's laws for two particles, its sway, and its flat output.

State x = (q, q_dot), q = (x, y, l, theta_x, theta_y): bridge, trolley, rope, sway. Inputs
u = (travel, traverse, hoist). SI units. Heights are measured from the rail, upwards: a load that
hangs is at z < 0.

The rope points from trolley to load along
d = (sin theta_x cos theta_y, sin theta_y, -cos theta_x cos theta_y).

Sources:
    Newton's second law for bridge and trolley along their rails, and for the load.
    Fliess, Lévine, Martin, Rouchon, Flatness and defect of non-linear systems: introductory theory
        and examples, Int. J. Control 61(6), 1995, section on the crane: the load is a flat output.
    Singer, Seering, Preshaping command inputs to reduce system vibration, J. Dynamic Systems,
        Measurement and Control 112, 1990: two equal halves, half a period apart.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

Array = NDArray[np.float64]
# time in [s] -> state, shape (10,); inputs, shape (3,); load from the rail's origin, shape (3,)
FlatMotion = Callable[[float], tuple[Array, Array, Array]]

COORDINATES = ("x", "y", "l", "theta_x", "theta_y")
STATES = (*COORDINATES, *(f"{name}_dot" for name in COORDINATES))
CONTROLS = ("travel", "traverse", "hoist")


@dataclass(frozen=True)
class Crane:
    """Masses in [kg], gravity in [m/s^2], drags of x, y, l in [N s/m] and of sway in [N m s]."""

    m: float = 1000.0
    M_b: float = 3000.0
    M_t: float = 700.0
    g: float = 9.81
    c_x: float = 400.0
    c_y: float = 150.0
    c_l: float = 2000.0
    c_s: float = 300.0


def rope(x: Array) -> Array:
    """Vector from trolley to load in [m], shape (..., 3)."""
    l, tx, ty = x[..., 2], x[..., 3], x[..., 4]  # noqa: E741  # the rope's length
    across = np.cos(ty)
    parts = [np.sin(tx) * across, np.sin(ty), -np.cos(tx) * across]
    return np.asarray(l[..., None] * np.stack(parts, axis=-1))


def load(x: Array) -> Array:
    """Load in [m] from the origin of the rails, shape (..., 3)."""
    return np.asarray(rope(x) + np.stack([x[..., 0], x[..., 1], 0 * x[..., 0]], axis=-1))


def tension(x: Array, u: Array, crane: Crane) -> Any:
    """Pull of the rope in [N], shape (...): the winch's force and its drag."""
    return u[..., 2] + crane.c_l * x[..., 7]


def forces(x: Array, u: Array, crane: Crane) -> Array:
    """Force of the rope on the load in [N], shape (3,); the trolley feels the opposite.

    The torques -c_s theta_dot do the work of a pair of forces across the rope: theta_x moves the
    load by l cos(theta_y) per radian, theta_y by l.
    """
    l, (tx, ty), (tx_dot, ty_dot) = x[2], x[3:5], x[8:10]  # noqa: E741
    along_x = np.array([np.cos(tx), 0, np.sin(tx)])
    along_y = np.array([-np.sin(tx) * np.sin(ty), np.cos(ty), np.cos(tx) * np.sin(ty)])
    damping = crane.c_s * (tx_dot / (l * np.cos(ty)) * along_x + ty_dot / l * along_y)
    return np.asarray(-tension(x, u, crane) * rope(x) / l - damping)


def accelerations(x: Array, u: Array, crane: Crane) -> Array:
    """Return q_ddot, shape (5,), by Newton's second law for bridge, trolley and load."""
    force = forces(x, u, crane)
    trolley = np.array(
        [
            (u[0] - crane.c_x * x[5] - force[0]) / (crane.M_b + crane.M_t),
            (u[1] - crane.c_y * x[6] - force[1]) / crane.M_t,
            0.0,
        ]
    )
    fall = force / crane.m - np.array([0, 0, crane.g])
    return np.concatenate([trolley[:2], spherical_accelerations(x, fall - trolley)])


def spherical_accelerations(x: Array, relative: Array) -> Array:
    """Return second derivatives of (l, theta_x, theta_y), shape (3,), from those of the rope.

    By differentiating l^2 = r.r, tan theta_x = -r_x / r_z and l sin theta_y = r_y twice.

    Args:
        relative: Acceleration of the load relative to the trolley in [m/s^2], shape (3,).
    """
    r, r_dot = rope(x), rope_rate(x)
    l, ty, l_dot, tx_dot, ty_dot = x[[2, 4, 7, 8, 9]]  # noqa: E741
    l_ddot = (r_dot @ r_dot + r @ relative - l_dot**2) / l
    flat, flat_dot = r[[0, 2]], r_dot[[0, 2]]
    turning = flat[0] * relative[2] - flat[1] * relative[0]
    tx_ddot = (turning - 2 * (flat @ flat_dot) * tx_dot) / (flat @ flat)
    rising = relative[1] - 2 * l_dot * ty_dot * np.cos(ty) - l_ddot * np.sin(ty)
    ty_ddot = (rising / l + np.sin(ty) * ty_dot**2) / np.cos(ty)
    return np.array([l_ddot, tx_ddot, ty_ddot])


def rope_rate(x: Array) -> Array:
    """Velocity of the load relative to the trolley in [m/s], shape (3,): radial and transverse."""
    l, tx, ty, l_dot, tx_dot, ty_dot = x[[2, 3, 4, 7, 8, 9]]  # noqa: E741
    along_x = np.array([np.cos(tx), 0, np.sin(tx)])
    along_y = np.array([-np.sin(tx) * np.sin(ty), np.cos(ty), np.cos(tx) * np.sin(ty)])
    swing = l * (np.cos(ty) * tx_dot * along_x + ty_dot * along_y)
    return np.asarray(rope(x) / l * l_dot + swing)


def state_derivative(x: Array, u: Array, crane: Crane) -> Array:
    """Return x_dot, shape (10,)."""
    return np.concatenate([x[5:], accelerations(x, u, crane)])


def generalised_forces(x: Array, u: Array, crane: Crane) -> Array:
    """Inputs and drags on the five coordinates, in [N] and [N m], shape (5,)."""
    drag = np.array([crane.c_x, crane.c_y, crane.c_l, crane.c_s, crane.c_s]) * x[5:]
    return np.asarray(np.array([u[0], u[1], -u[2], 0, 0]) - drag)


def kinetic_energy(x: Array, crane: Crane) -> float:
    """T in [J]: two masses on rails and a particle."""
    x_dot, y_dot = x[5:7]
    particle = rope_rate(x) + np.array([x_dot, y_dot, 0])
    rails = crane.M_b * x_dot**2 + crane.M_t * (x_dot**2 + y_dot**2)
    return float(rails + crane.m * particle @ particle) / 2


def sway_frequencies(l: float, crane: Crane) -> tuple[float, float]:  # noqa: E741
    """Angular frequencies in [rad/s] along x and along y: free masses, no drag, tension m g.

    Newton: M x_ddot = m g s, l s_ddot = -g s - x_ddot, hence s_ddot = -(1 + m / M) (g / l) s.
    """
    along_x = (1 + crane.m / (crane.M_b + crane.M_t)) * crane.g / l
    along_y = (1 + crane.m / crane.M_t) * crane.g / l
    return float(np.sqrt(along_x)), float(np.sqrt(along_y))


def residual_sway(acceleration: float, duration: float, frequency: float, g: float) -> float:
    """Amplitude in [rad] that a constant acceleration of the trolley leaves behind, for small sway.

    s_ddot + w^2 s = -(a / g) w^2: a pulse of length tau leaves 2 (a / g) |sin(w tau / 2)|.
    """
    return float(2 * abs(acceleration / g * np.sin(frequency * duration / 2)))


def rest_to_rest(tau: Any) -> Any:
    """Polynomial of degree 13 from 0 to 1 for tau from 0 to 1; six derivatives vanish at the ends.

    The integral of s^6 (1 - s)^6, divided by its value B(7, 7) = 6!^2 / 13! at the end.
    """
    s = sp.Symbol("s")
    scale = sp.Rational(sp.factorial(13), sp.factorial(6) ** 2)
    return scale * sp.integrate(sp.expand(s**6 * (1 - s) ** 6), (s, 0, tau))


def detour(tau: Any) -> Any:
    """Polynomial of degree 14 that goes to 1 and back; six derivatives vanish at both ends."""
    return (4 * tau * (1 - tau)) ** 7


def flat_motion(path: Sequence[Any], t: Any, crane: Crane) -> FlatMotion:
    """Return the motion and the inputs that carry the load along a path.

    Without damping of the sway the rope can only pull along itself, so that its direction is that
    of p_ddot + g e_z; where that line meets the rail is the trolley. The inputs overcome the other
    drags.

    Args:
        path: Load (p_x, p_y, p_z) as expressions in ``t``, four times differentiable, below the
            rail.
        t: Time in [s].
        crane: Its ``c_s`` is taken as 0.
    """
    q, rates, pull = _flat_state(path, t, crane)
    inputs = _flat_inputs(q, rates, pull, path, t, crane)
    evaluate = sp.lambdify(t, [*q, *rates, *inputs, *path], cse=True)

    def at(time: float) -> tuple[Array, Array, Array]:
        values = np.array(evaluate(time), dtype=np.float64)
        return values[:10], values[10:13], values[13:]

    return at


def _flat_state(path: Sequence[Any], t: Any, crane: Crane) -> tuple[list[Any], list[Any], Any]:
    """Return q, q_dot and the tension as expressions."""
    a_x, a_y, a_z = (sp.diff(p, t, 2) for p in path)
    weight = a_z + crane.g
    r_x, r_y, r_z = path[2] * a_x / weight, path[2] * a_y / weight, path[2]
    l = sp.sqrt(r_x**2 + r_y**2 + r_z**2)  # noqa: E741
    q = [path[0] - r_x, path[1] - r_y, l, sp.atan2(r_x, -r_z), sp.asin(r_y / l)]
    pull = crane.m * sp.sqrt(a_x**2 + a_y**2 + weight**2)
    return q, [sp.diff(c, t) for c in q], pull


def _flat_inputs(
    q: list[Any], rates: list[Any], pull: Any, path: Sequence[Any], t: Any, crane: Crane
) -> list[Any]:
    """Return travel, traverse and hoist by Newton's second law along the rails and the rope."""
    pull_x, pull_y = (pull * (path[i] - q[i]) / q[2] for i in (0, 1))
    travel = (crane.M_b + crane.M_t) * sp.diff(rates[0], t) + crane.c_x * rates[0] - pull_x
    traverse = crane.M_t * sp.diff(rates[1], t) + crane.c_y * rates[1] - pull_y
    return [travel, traverse, pull - crane.c_l * rates[2]]
