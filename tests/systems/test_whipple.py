"""The bicycle against what has been published about it, linear and not."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from kinolab import systems
from kinolab.dynamics import Model
from tests.oracles import whipple as oracle

Array = NDArray[np.float64]

NAMES = ("x", "y", "psi", "phi", "theta", "delta", "theta_R", "theta_F")
STATES = (*NAMES, "phi_dot", "delta_dot", "theta_R_dot")
RADIUS = 0.3  # [m] of the rear wheel
TO_THE_RIGHT = np.diag([1.0, -1.0])  # lean and steer as the source counts them
SPEEDS = np.arange(1.0, 7.0)  # [m/s]


@pytest.fixture(scope="module")
def model() -> Model:
    return systems.get("whipple").model()


def state(**values: float) -> Array:
    return np.array([values.get(name, 0.0) for name in STATES])


def test_states_and_controls_carry_the_authors_names(model: Model) -> None:
    assert model.state_names == STATES
    assert model.control_names == ("drive", "steer")


# The linear bicycle


def riding(v: float) -> Array:
    return state(theta_R_dot=v / RADIUS)


def masses(model: Model) -> Array:
    """Mass matrix of (lean, steer) along what the wheels allow, shape (2, 2)."""
    rest = state()
    S = np.array([model.velocity(rest + unit) for unit in np.eye(len(STATES))[8:10]]).T
    return np.asarray(TO_THE_RIGHT @ S.T @ model.mass_matrix(rest) @ S @ TO_THE_RIGHT)


def slopes(model: Model, v: float) -> tuple[Array, Array]:
    """Derivatives of the accelerations of (lean, steer) by their values and rates at a speed."""
    A, _ = model.jacobian(riding(v))
    parts = (A[np.ix_([8, 9], columns)] for columns in ([3, 5], [8, 9]))
    stiff, damped = (np.asarray(TO_THE_RIGHT @ part @ TO_THE_RIGHT) for part in parts)
    return stiff, damped


def test_masses_are_the_published_ones(model: Model) -> None:
    np.testing.assert_allclose(masses(model), oracle.M, rtol=1e-12)


def test_damping_is_the_published_one_times_the_speed(model: Model) -> None:
    for v in SPEEDS:
        found = -masses(model) @ slopes(model, v)[1] / v
        np.testing.assert_allclose(found, oracle.C1, rtol=1e-10, atol=1e-10)


def test_stiffness_is_that_of_gravity_and_of_the_speed_squared(model: Model) -> None:
    """g K0 + v^2 K2 = -M A at every speed; both from least squares over seven of them."""
    speeds = np.array([0.0, *SPEEDS])
    found = np.array([-masses(model) @ slopes(model, v)[0] for v in speeds])
    design = np.stack([np.full_like(speeds, oracle.G), speeds**2], axis=1)
    (K0, K2), *_ = np.linalg.lstsq(design, found.reshape(7, 4), rcond=None)
    np.testing.assert_allclose(K0.reshape(2, 2), oracle.K0, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(K2.reshape(2, 2), oracle.K2, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(design @ [K0, K2], found.reshape(7, 4), rtol=0, atol=1e-8)


def linear(model: Model, v: float) -> Array:
    """A of (lean, steer, lean rate, steer rate) at a speed in [m/s], shape (4, 4)."""
    A, _ = model.jacobian(riding(v))
    kept = [3, 5, 8, 9]
    return np.asarray(A[np.ix_(kept, kept)])


def rates(model: Model, v: float) -> Array:
    """Eigenvalues in [1/s], sorted."""
    return np.sort_complex(np.linalg.eigvals(linear(model, v)))


@pytest.mark.parametrize("v", oracle.EIGENVALUES)
def test_eigenvalues_are_the_published_ones(model: Model, v: float) -> None:
    expected = np.sort_complex(np.array(oracle.EIGENVALUES[v]))
    np.testing.assert_allclose(rates(model, v), expected, rtol=1e-8)


@pytest.mark.parametrize("v", [0.0, 2.5, 4.5, 9.0])
def test_the_published_matrices_and_kanes_method_move_like_it(model: Model, v: float) -> None:
    """Both engines, at speeds that no table has; SymPy's numbers have 15 digits."""
    expected = np.sort_complex(np.linalg.eigvals(oracle.state_matrix(v)))
    np.testing.assert_allclose(rates(model, v), expected, rtol=1e-9, atol=1e-9)
    flip = np.kron(np.eye(2), TO_THE_RIGHT)
    lower = (flip @ linear(model, v) @ flip)[2:]
    np.testing.assert_allclose(lower, oracle.kane_matrix(v), rtol=1e-11, atol=1e-11)


def test_it_rides_by_itself_between_the_weave_and_the_capsize_speed(model: Model) -> None:
    def fastest(v: float) -> float:
        return float(rates(model, v).real.max())

    weave = brentq(fastest, 4.0, 5.0, xtol=1e-12)
    capsize = brentq(fastest, 5.5, 6.5, xtol=1e-12)
    assert weave == pytest.approx(oracle.WEAVE, abs=1e-9)  # [m/s]
    assert capsize == pytest.approx(oracle.CAPSIZE, abs=1e-9)
    assert fastest(5.0) < 0 < min(fastest(3.5), fastest(7.0))


# Far from straight riding


@cache
def turned() -> Array:
    """The published state, whose wheels turn against the leaning plane and the fork."""
    posture = {
        "phi": oracle.TURNED["lean"],
        "theta": oracle.TURNED["pitch"],
        "delta": oracle.TURNED["steer"],
    }
    return state(
        **posture,
        phi_dot=oracle.RATES["lean"],
        delta_dot=oracle.RATES["steer"],
        theta_R_dot=oracle.RATES["rear"] + oracle.RATES["pitch"],
    )


def test_the_front_wheel_is_on_the_ground_at_the_published_pitch(model: Model) -> None:
    residual = model.constraint_residual(turned())
    assert abs(residual[-1]) < 1e-13  # [m]: the table has 14 digits


def test_the_wheels_turn_bicycle_and_front_wheel_at_the_published_rates(model: Model) -> None:
    """Which the two wheels' rolling and the front one's contact determine."""
    found = dict(zip(NAMES, model.velocity(turned()), strict=True))
    for name, key in (("psi", "heading"), ("theta", "pitch"), ("theta_F", "front")):
        assert found[name] == pytest.approx(oracle.RATES[key], abs=1e-12)


def test_accelerations_are_the_published_ones(model: Model) -> None:
    """All six: the dependent ones are differences of the rates along f, of sixth order."""
    x, f = turned(), model.f(turned())
    given = oracle.ACCELERATIONS
    assert f[8] == pytest.approx(given["lean"], abs=1e-11)
    assert f[9] == pytest.approx(given["steer"], abs=1e-11)
    assert f[10] == pytest.approx(given["rear"] + given["pitch"], abs=1e-11)
    h, places = 1e-2, np.array([-3, -2, -1, 1, 2, 3])  # [s]
    along = (
        np.array([-1, 9, -45, 45, -9, 1]) / (60 * h) @ model.velocity(x + h * places[:, None] * f)
    )
    for name, key in (("psi", "heading"), ("theta", "pitch"), ("theta_F", "front")):
        assert along[NAMES.index(name)] == pytest.approx(given[key], abs=1e-7)


def test_it_keeps_its_energy_and_its_contact_while_it_recovers(model: Model) -> None:
    """Pushed at a speed at which it rides by itself; from rtol 1e-11 over 5 s."""
    start = riding(4.6) + state(phi_dot=0.5)
    t = np.linspace(0.0, 5.0, 51)
    run = solve_ivp(
        lambda _, x: model.f(x), (0, 5), start, "DOP853", t_eval=t, rtol=1e-11, atol=1e-12
    )
    path = np.ascontiguousarray(run.y.T)
    energy = np.sum(model.energy(path), axis=0)
    assert np.ptp(energy) < 1e-7  # [J], of 1900
    assert np.abs(model.constraint_residual(path)).max() < 1e-9  # [m], [m/s]
    assert np.abs(path[:, 3]).max() > 0.05  # [rad]: it did lean
    assert np.abs(path[-1, [3, 5]]).max() < 0.2 * np.abs(path[:, [3, 5]]).max()
