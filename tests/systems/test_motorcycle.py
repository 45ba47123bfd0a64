"""The motorcycle against the published roll equation and a derivation by hand."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from kinolab import systems
from kinolab.dynamics import Model
from tests.oracles import motorcycle as oracle
from tests.oracles.motorcycle import Motorcycle

Array = NDArray[np.float64]

BIKE = Motorcycle()
OTHER = Motorcycle(m=30.0, p=0.8, c=0.5, b=1.0, R=0.35)  # a bicycle
STRAIGHT = 1e-12  # [m] or [rad]


@pytest.fixture(scope="module")
def model() -> Model:
    return systems.get("motorcycle").model().plant


@pytest.fixture(scope="module")
def samples() -> tuple[Array, Array]:
    """Fifty random states (50, 9), at up to 20 m/s, and inputs (50, 2)."""
    rng = np.random.default_rng(1995)
    scales = [5, 5, 3, 0.8, 0.6, 3, 2, 1.5, 60]
    return rng.uniform(-1, 1, (50, 9)) * scales, rng.uniform(-1, 1, (50, 2)) * [300, 15]


def state(**values: float) -> Array:
    return np.array([values.get(name, 0.0) for name in oracle.STATES])


def test_states_and_controls_carry_the_authors_names(model: Model) -> None:
    assert model.state_names == oracle.STATES
    assert model.control_names == ("drive", "steer")


@pytest.mark.parametrize("bike", [BIKE, OTHER])
def test_motion_is_the_one_derived_by_hand(
    model: Model, samples: tuple[Array, Array], bike: Motorcycle
) -> None:
    for x, u in zip(*samples, strict=True):
        expected = oracle.state_derivative(x, u, bike)
        found = model.f(x, u, **asdict(bike))
        np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-10)


@pytest.mark.parametrize("bike", [BIKE, OTHER])
def test_the_lean_obeys_the_published_roll_equation(
    model: Model, samples: tuple[Array, Array], bike: Motorcycle
) -> None:
    """To 1e-10 of terms that reach 200 m/s^2."""
    for x, u in zip(*samples, strict=True):
        x_dot = model.f(x, u, **asdict(bike))
        assert abs(oracle.roll_residual(x, x_dot, bike)) < 1e-10 * (1 + abs(x_dot[6]))
        x_dot[6] += 0.1
        assert abs(oracle.roll_residual(x, x_dot, bike)) > 1e-3  # another acceleration does not


@pytest.mark.parametrize(("v", "delta"), [(3.0, 0.3), (10.0, -0.08), (15.0, 0.03), (5.0, -0.15)])
def test_a_steady_turn_needs_no_input(model: Model, v: float, delta: float) -> None:
    """It leans into the turn, at tan(alpha) = -(1 + p sigma sin(alpha)) sigma v^2 / g."""
    lean = oracle.steady_lean(v, delta, BIKE)
    assert lean * delta < 0
    x = state(psi=0.4, alpha=lean, delta=delta, phi_dot=v / BIKE.R)
    np.testing.assert_allclose(model.f(x)[6:], 0.0, atol=1e-10)
    sigma = np.tan(delta) / BIKE.b
    assert model.velocity(x)[2] == pytest.approx(sigma * v, abs=1e-12)  # [rad/s]
    x[3] += 0.05
    assert np.abs(model.f(x)[6:]).max() > 0.1


def test_a_steady_turn_is_a_circle(model: Model) -> None:
    """Of radius b / tan(delta), about a centre to the left; errors grow by exp(3.9 t)."""
    v, delta = 5.0, 0.15
    lean = oracle.steady_lean(v, delta, BIKE)
    start = state(alpha=lean, delta=delta, phi_dot=v / BIKE.R)
    t = np.linspace(0.0, 2.0, 21)
    run = solve_ivp(
        lambda _, x: model.f(x), (0, 2), start, "DOP853", t_eval=t, rtol=1e-12, atol=1e-13
    )
    radius = BIKE.b / np.tan(delta)
    distances = np.hypot(run.y[0], run.y[1] - radius)
    np.testing.assert_allclose(distances, radius, atol=1e-7)  # [m]


@pytest.mark.parametrize("v", [0.0, 2.0, 15.0])
def test_with_its_handlebar_held_straight_it_falls_like_a_rod(model: Model, v: float) -> None:
    """At any speed: a lean grows at sqrt(g / p), for it is steering that brings it back."""
    A, _ = model.jacobian(state(phi_dot=v / BIKE.R))
    lean = A[np.ix_([3, 6], [3, 6])]
    rates = np.sort(np.linalg.eigvals(lean).real)
    np.testing.assert_allclose(rates, np.sqrt(BIKE.g / BIKE.p) * np.array([-1, 1]), rtol=1e-12)


def test_to_lean_left_one_first_steers_right(model: Model) -> None:
    """Turning the handlebar tilts by c v / (b p), having turned it by v^2 / (b p), to the right.

    Turning left the mass is first carried left under the contact, then thrown right.
    """
    v = 10.0
    A, _ = model.jacobian(state(phi_dot=v / BIKE.R))
    assert A[6, 7] == pytest.approx(BIKE.c * v / (BIKE.b * BIKE.p), rel=1e-12)
    assert A[6, 4] == pytest.approx(v**2 / (BIKE.b * BIKE.p), rel=1e-12)


def test_the_drive_works_on_the_speed_alone(model: Model) -> None:
    """Riding straight, v_dot = torque / (m R) and nothing leans or steers."""
    f = model.f(state(phi_dot=30.0), [200.0, 0.0])
    assert f[8] * BIKE.R == pytest.approx(200.0 / (BIKE.m * BIKE.R), rel=1e-12)
    np.testing.assert_allclose(f[6:8], 0.0, atol=STRAIGHT)
