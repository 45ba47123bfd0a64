"""The coin that rolls and leans, against Newton and Euler.

Coordinates (x, y, psi, theta, phi): contact point, heading, lean and roll. The contact's axes are
the heading, left and up; a lean theta > 0 is to the right. Of the disk's axes, k points from the
contact to the centre and j along the axle to the left:

    j = (0, cos theta, sin theta), k = (0, -sin theta, cos theta).

With moments of inertia A about the axle and B about a diameter, rolling at the rates psi_dot = W
and phi_dot = s, the angular velocity is

    w = theta_dot i + (s + W sin theta) j + W cos theta k,

and no slip gives the centre the velocity w x R k.

Steady circular motion has H = A (s + W sin theta) j + B W cos theta k, carried around at W, and
the centre accelerates by R W (s + W sin theta) to the left. The contact's force, that times m plus
the weight, has the moment m R (g sin theta + cos theta R W (s + W sin theta)) about the centre, so

    (A + m R^2) W s cos theta + (A + m R^2 - B) W^2 sin theta cos theta + m g R sin theta = 0.

Near straight rolling B psi_ddot = -A s theta_dot and
(B + m R^2) theta_ddot = m g R theta + (A + m R^2) s psi_dot. With the first integrated,

    (B + m R^2) theta_ddot = (m g R - A (A + m R^2) s^2 / B) theta + constant,

stable iff s^2 > B m g R / (A (A + m R^2)): g / (3 R) for a disk, g / (4 R) for a hoop.

Source: Neimark, Fufaev, Dynamics of Nonholonomic Systems, 1972, treat the same disk; the formulas
are derived here.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from kinolab import systems
from kinolab.dynamics import (
    Body,
    Frame,
    Model,
    System,
    angle,
    length,
    move,
    parameter,
    rot_x,
    rot_y,
    rot_z,
    toward,
    velocity,
    zero,
)
from tests.oracles import falling_disk as oracle
from tests.oracles.falling_disk import FallingDisk

Array = NDArray[np.float64]

M, R, G = 1.0, 0.3, 9.81
DISK, ANNULUS, HOOP = 0.5, 0.8, 1.0  # k = A / (m R^2)
NAMES = ("x", "y", "psi", "theta", "phi", "psi_dot", "theta_dot", "phi_dot")
LEAN, TURN, SPIN = 0.2, 1.0, -4.584636549751613  # a steady circle of the disk


def material_disk() -> System:
    """The same coin, whose constraint is that the matter at its lowest point does not move."""
    m, r = parameter("m", M, "kg"), parameter("R", R, "m")
    about_axle, across = parameter("A", 0.045, "kg m^2"), parameter("B", 0.0225, "kg m^2")
    x, y, psi = length("x"), length("y"), angle("psi")
    theta, phi = angle("theta", -1.5, 1.5), angle("phi")
    fork = move(x, y) @ rot_z(psi) @ rot_x(theta) @ move(0, 0, r)  # leans, does not spin
    coin = Body("coin", fork @ rot_y(phi), mass=m, inertia=(across, about_axle, across))
    along, aside = contact_velocity(coin.frame, phi, r)
    return System(
        "material_disk",
        bodies=[coin],
        gravity=toward("-z", parameter("g", G, "m/s^2")),
        constraints=[zero(along, "no slip ahead"), zero(aside, "no slip aside")],
        velocities=[psi, theta, phi],
    )


def contact_velocity(disk: Frame, phi: Any, r: Any) -> tuple[Any, Any]:
    """Velocity of the disk's lowest point along and across the fork, from the body velocity.

    The lowest point is at -R k, which in the axes of the spinning disk is turned back by phi.
    """
    V, back = velocity(disk), sympy.rot_ccw_axis2(phi)
    lowest = back.T * sympy.Matrix([0, 0, -r])
    slip = back * (V.linear + V.angular.cross(lowest))
    return slip[0], slip[1]


@pytest.fixture(scope="module")
def model() -> Model:
    return systems.get("falling_disk").model().plant


def moments(k: float) -> dict[str, float]:
    """Moments about the axle and a diameter of a flat round body."""
    return {"A": k * M * R**2, "B": k * M * R**2 / 2}


def disk(k: float) -> FallingDisk:
    return FallingDisk(m=M, R=R, g=G, **moments(k))


@pytest.fixture(scope="module")
def samples() -> Array:
    """Fifty random states, shape (50, 8), leaning by up to 1.2 rad."""
    x = np.random.default_rng(1972).uniform(-3, 3, (50, 8))
    x[:, 3] *= 0.4
    return x


def state(**values: float) -> Array:
    return np.array([values.get(name, 0.0) for name in NAMES])


def run(model: Model, start: Array, t: Array, **parameters: float) -> Array:
    """States at the times ``t``, shape (len(t), 8), by DOP853 near machine precision."""
    done = solve_ivp(
        lambda _, x: model.f(x, **parameters),
        (float(t[0]), float(t[-1])),
        start,
        "DOP853",
        t_eval=t,
        rtol=1e-12,
        atol=1e-13,
    )
    return np.asarray(done.y.T)


def test_states_carry_the_authors_names(model: Model) -> None:
    assert model.state_names == NAMES
    assert model.control_names == ("drive", "steer")


# Hand derivations


def torques(samples: Array) -> Array:
    return np.random.default_rng(1).uniform(-0.5, 0.5, (len(samples), 2))


@pytest.mark.parametrize("k", [DISK, ANNULUS, HOOP])
def test_accelerations_are_those_derived_by_hand(model: Model, samples: Array, k: float) -> None:
    """Under both torques; rounding is divided by B = 0.02 kg m^2 and by cos 1.2."""
    u = torques(samples)
    expected = oracle.accelerations(samples, u, disk(k))
    np.testing.assert_allclose(model.f(samples, u, k=k)[:, 5:], expected, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("k", [DISK, ANNULUS, HOOP])
def test_the_matter_at_the_contact_is_at_rest(model: Model, samples: Array, k: float) -> None:
    """What ties the contact's track to the roll is that the lowest point does not slip."""
    expected = material_disk().model().f(samples, **moments(k))
    np.testing.assert_allclose(model.f(samples, k=k), expected, rtol=1e-11, atol=1e-11)


def test_a_coin_that_is_held_upright_is_the_one_that_cannot_fall(
    model: Model, samples: Array
) -> None:
    """Whatever it does but lean: its lean's acceleration is what holding it takes."""
    upright = samples * [1, 1, 1, 0, 1, 1, 0, 1]
    u, kept = torques(samples), [0, 1, 2, 4, 5, 7]
    coin = systems.get("rolling_disk", m=M, R=R).model()
    expected = coin.f(upright[:, kept], u)
    np.testing.assert_allclose(model.f(upright, u)[:, kept], expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("spin", [-4.0, 0.0, 6.0])
def test_steering_tilts_the_coin_only_while_it_rolls(model: Model, spin: float) -> None:
    """A turn of the torque's steer / B tilts it by (A + m R^2) s / (B + m R^2) as much."""
    A, B = model.jacobian(state(phi_dot=spin))
    coin = disk(DISK)
    expected = coin.rolling * spin / (coin.B + M * R**2) / coin.B
    assert (A @ B)[6, 1] == pytest.approx(expected, abs=1e-10)


# Newton and Euler


def axes(x: Array) -> tuple[Array, Array, Array]:
    """Heading i, axle j, and k from contact to centre, in the world, each of shape (..., 3)."""
    psi, theta = x[..., 2], x[..., 3]
    ahead = np.stack([np.cos(psi), np.sin(psi), 0 * psi], axis=-1)
    left = np.stack([-np.sin(psi), np.cos(psi), 0 * psi], axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    c, s = np.cos(theta)[..., None], np.sin(theta)[..., None]
    return ahead, c * left + s * up, c * up - s * left


def spins(x: Array) -> Array:
    """Angular velocity along (i, j, k) in [rad/s], shape (..., 3)."""
    theta, turn, leaning, roll = x[..., 3], x[..., 5], x[..., 6], x[..., 7]
    return np.stack([leaning, roll + turn * np.sin(theta), turn * np.cos(theta)], axis=-1)


def centre_velocity(x: Array) -> Array:
    """w x R k in the world in [m/s], shape (..., 3): i x k = -j and j x k = i."""
    i, j, _ = axes(x)
    w = spins(x)
    return R * (w[..., 1:2] * i - w[..., 0:1] * j)


def angular_momentum(x: Array, given: dict[str, float]) -> Array:
    """H about the centre, in the world in [N m s], shape (..., 3)."""
    parts = spins(x) * [given["B"], given["A"], given["B"]]
    return sum((parts[..., n : n + 1] * axis for n, axis in enumerate(axes(x))), np.zeros(3))


def drift(quantity: Any, x: Array, slope: Array) -> Array:
    """Derivative of a function of the state along x + t f: a central difference of sixth order."""
    h, places = 1e-2, np.array([-3, -2, -1, 1, 2, 3])  # [s]
    values = quantity(x + h * places[:, None] * slope / (1 + np.abs(slope).max()))
    weights = np.array([-1, 9, -45, 45, -9, 1]) / (60 * h)
    return np.asarray(weights @ values * (1 + np.abs(slope).max()))


@pytest.mark.parametrize("k", [DISK, ANNULUS, HOOP])
def test_the_force_at_the_contact_moves_the_centre_and_turns_the_disk(
    model: Model, samples: Array, k: float
) -> None:
    check_newton_and_euler(lambda x: model.f(x, k=k), samples, moments(k))


def test_a_body_that_is_not_flat_obeys_newton_and_euler_too(samples: Array) -> None:
    """A = 0.05, B = 0.04, which no k gives."""
    found, other = material_disk().model(), {"A": 0.05, "B": 0.04}
    check_newton_and_euler(lambda x: found.f(x, **other), samples, other)
    expected = oracle.accelerations(samples, np.zeros((50, 2)), FallingDisk(**other))
    np.testing.assert_allclose(found.f(samples, **other)[:, 5:], expected, rtol=1e-11, atol=1e-11)


def check_newton_and_euler(f: Any, samples: Array, given: dict[str, float]) -> None:
    """Newton gives the force, Euler is then to hold: H_dot = -R k x F. The difference errs by h^6.

    Moments are about 1 N m.
    """
    for x in samples:
        slope = f(x)
        force = M * (drift(centre_velocity, x, slope) + np.array([0, 0, G]))
        turning = drift(lambda at: angular_momentum(at, given), x, slope)
        moment = -R * np.cross(axes(x)[2], force)
        np.testing.assert_allclose(turning, moment, rtol=0, atol=1e-9)  # [N m]


def test_the_contact_moves_where_the_disk_rolls(model: Model, samples: Array) -> None:
    """(x_dot, y_dot) = R phi_dot along the heading, whatever the lean."""
    for x in samples:
        expected = [R * x[7] * np.cos(x[2]), R * x[7] * np.sin(x[2]), *x[5:]]
        np.testing.assert_allclose(model.velocity(x), expected, rtol=0, atol=1e-12)


def test_the_centre_is_above_the_contact_on_the_side_of_the_lean(
    model: Model, samples: Array
) -> None:
    """What sign a lean has, which the steady circles depend on."""
    for x in samples:
        centre = model.frames(x)[0].reshape(3, 4)[:, 3]
        np.testing.assert_allclose(centre, [*x[:2], 0] + R * axes(x)[2], rtol=0, atol=1e-12)


# Energy


def energy(x: Array, k: float) -> Array:
    """Kinetic and potential energy in [J] by Koenig's theorem, shape (...)."""
    turning = (spins(x) ** 2 * [k * M * R**2 / n for n in (2, 1, 2)]).sum(axis=-1)
    moving = M * (centre_velocity(x) ** 2).sum(axis=-1)
    return np.asarray((turning + moving) / 2 + M * G * R * np.cos(x[..., 3]))


@pytest.mark.parametrize("k", [DISK, ANNULUS, HOOP])
def test_energies_are_those_of_koenig(model: Model, samples: Array, k: float) -> None:
    found = np.sum(model.energy(samples, k=k), axis=0)
    np.testing.assert_allclose(np.diff(found - energy(samples, k)), 0.0, atol=1e-12)


def test_a_wobbling_disk_keeps_its_energy(model: Model) -> None:
    """Rolling does no work: drift is integration error, 1e-12 per step."""
    start = state(theta=0.3, psi_dot=0.5, theta_dot=0.4, phi_dot=6.0)
    path = run(model, start, np.linspace(0.0, 5.0, 101))
    assert np.ptp(path[:, 3]) > 0.3  # [rad]: it does wobble
    assert np.ptp(energy(path, DISK)) < 1e-9  # [J], of 4
    assert np.ptp(np.sum(model.energy(path), axis=0)) < 1e-9


# Steady circles


def test_the_spin_of_one_circle_is_as_known() -> None:
    assert oracle.steady_spin(LEAN, TURN, disk(DISK)) == pytest.approx(SPIN, abs=1e-14)


@pytest.mark.parametrize("k", [DISK, ANNULUS, HOOP])
@pytest.mark.parametrize(("lean", "turn"), [(0.2, 1.0), (-0.7, 2.5), (1.1, -0.8), (0.4, 6.0)])
def test_a_steady_circle_needs_no_acceleration(
    model: Model, k: float, lean: float, turn: float
) -> None:
    spin = oracle.steady_spin(lean, turn, disk(k))
    x = state(psi=0.4, theta=lean, phi=0.3, psi_dot=turn, phi_dot=spin)
    np.testing.assert_allclose(model.f(x, k=k)[5:], 0.0, rtol=0, atol=1e-10)  # [rad/s^2]
    x[7] += 0.1
    assert np.abs(model.f(x, k=k)[5:]).max() > 1e-2  # another spin does


def test_a_steady_circle_lasts(model: Model) -> None:
    """Lean, yaw rate and spin stay, and the contact runs around a point at R |s / W|."""
    start = state(theta=LEAN, psi_dot=TURN, phi_dot=SPIN)
    t = np.linspace(0.0, 5.0, 51)
    path = run(model, start, t)
    kept = path[:, [3, 5, 6, 7]]
    np.testing.assert_allclose(kept, np.tile(start[[3, 5, 6, 7]], (51, 1)), rtol=0, atol=1e-8)
    radius = R * SPIN / TURN
    expected = radius * np.stack([np.sin(t), 1 - np.cos(t)], axis=-1)
    np.testing.assert_allclose(path[:, :2], expected, rtol=0, atol=1e-8)  # [m]


# Straight rolling


def growth(model: Model, spin: float, k: float) -> float:
    """Squared rate of the lean's mode in [1/s^2]; positive if straight rolling is unstable.

    The other modes of (theta, psi_dot, theta_dot, phi_dot) are 0: the disk may roll along any
    circle near the line, at any speed.
    """
    kept = [3, 5, 6, 7]
    A, _ = model.jacobian(state(phi_dot=spin), k=k)
    squares = np.linalg.eigvals(A[np.ix_(kept, kept)]) ** 2
    return float(squares[np.argmax(np.abs(squares))].real)


@pytest.mark.parametrize("k", [DISK, ANNULUS, HOOP])
@pytest.mark.parametrize("spin", [0.0, 1.5, -2.5, 4.0, -9.0])
def test_a_lean_grows_or_swings_at_the_rate_of_the_gyroscope(
    model: Model, k: float, spin: float
) -> None:
    assert growth(model, spin, k) == pytest.approx(oracle.growth(spin, disk(k)), rel=1e-10)


@pytest.mark.parametrize(("k", "share"), [(DISK, 3.0), (HOOP, 4.0)])
def test_straight_rolling_is_stable_above_its_critical_spin(
    model: Model, k: float, share: float
) -> None:
    """s^2 = g / (3 R) for a disk, g / (4 R) for a hoop; bisected to 1e-9 rad/s."""
    critical = np.sqrt(G / (share * R))
    assert growth(model, 0.99 * critical, k) > 0.01
    assert growth(model, 1.01 * critical, k) < -0.01
    found = brentq(lambda s: growth(model, s, k), 1.0, 9.0, xtol=1e-9)
    assert found == pytest.approx(critical, abs=1e-6)  # [rad/s]


def test_the_critical_spin_of_one_disk_is_as_known() -> None:
    assert np.sqrt(G / (3 * R)) == pytest.approx(3.3015148, abs=1e-7)


@pytest.mark.parametrize("spin", [2.0, 3.0, 3.6, 6.0])
def test_a_slow_disk_falls_and_a_fast_one_swings(model: Model, spin: float) -> None:
    """From a lean of 1e-6 without turn; it stays below 0.003, and linearising errs by its square.

    With s_c critical, theta swings about theta_0 s^2 / (s^2 - s_c^2), or leaves that as cosh.
    """
    t, small = np.linspace(0.0, 2.0, 21), 1e-6  # [s], [rad]
    path = run(model, state(theta=small, phi_dot=spin), t)
    middle = small * spin**2 / (spin**2 - G / (3 * R))
    rate = np.emath.sqrt(-growth(model, spin, DISK))  # imaginary for the slow ones
    expected = middle + (small - middle) * np.cos(rate * t).real
    np.testing.assert_allclose(path[:, 3], expected, rtol=0, atol=1e-5 * np.abs(expected).max())
    assert bool(path[-1, 3] > 100 * small) == (spin < 3.3)


# Symmetry


def test_the_floor_has_no_preferred_place_or_direction(model: Model) -> None:
    start, yaw = state(theta=0.3, psi_dot=0.5, theta_dot=0.4, phi_dot=6.0), 2.0
    turned = start + state(x=4.0, y=-7.0, psi=yaw)
    t = np.linspace(0.0, 3.0, 31)
    path, image = run(model, start, t), run(model, turned, t)
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    np.testing.assert_allclose(image[:, :2], path[:, :2] @ turn.T + [4, -7], rtol=0, atol=1e-8)
    np.testing.assert_allclose(image[:, 3:], path[:, 3:], rtol=0, atol=1e-8)
