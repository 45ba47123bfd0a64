"""The derived upright coin against oracles that know nothing of the derivation."""

from collections.abc import Callable, Mapping
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import kinolab.systems
from tests.oracles import rolling_disk as oracle
from tests.oracles.rolling_disk import Coin

Array = NDArray[np.float64]

COIN = Coin()
OTHER = Coin(m=2.3, R=0.4)
START = np.array([0.3, -0.2, 0.5, 1.0, 0.8, 3.0])  # turning left while rolling forward
ANGLES = [2, 3]  # psi, phi: compared on the circle
ROUNDING = 1e-12  # SI; values reach 100, a few operations lose a few units in the 16th digit


@pytest.fixture(scope="module")
def model() -> Any:
    return kinolab.systems.get("rolling_disk").model()


@pytest.fixture(scope="module")
def samples() -> tuple[Array, Array]:
    """One hundred random states (100, 6) and torques (100, 2)."""
    rng = np.random.default_rng(2003)
    return rng.uniform(-3, 3, (100, 6)), rng.uniform(-1, 1, (100, 2))


def torques(t: float) -> Array:
    """Smooth inputs in [N m]: the coin speeds up, slows down and turns both ways."""
    return np.array([0.3 * np.sin(t), 0.02 * np.cos(0.7 * t)])


def simulate(f: Callable[[Array, Array], Array], t: Array, inputs: oracle.Torques) -> Array:
    """Integrate ``f`` from START with DOP853 near machine precision, shape (len(t), 6)."""
    span = (float(t[0]), float(t[-1]))
    run = solve_ivp(
        lambda s, x: f(x, inputs(s)), span, START, "DOP853", t_eval=t, rtol=1e-12, atol=1e-13
    )
    return np.asarray(run.y.T, dtype=np.float64)


def difference(actual: Array, expected: Array) -> float:
    """Largest difference of two sets of states, angles on the circle."""
    gap = np.asarray(actual) - expected
    gap[..., ANGLES] = np.remainder(gap[..., ANGLES] + np.pi, 2 * np.pi) - np.pi
    return float(np.abs(gap).max())


# The oracles themselves


@pytest.mark.parametrize("coin", [COIN, OTHER])
def test_lagrange_kane_and_multipliers_agree_with_the_closed_form(
    coin: Coin, samples: tuple[Array, Array]
) -> None:
    lagrange, kane = oracle.lagrange_accelerations(coin), oracle.kane_accelerations(coin)
    for x, u in zip(*samples, strict=True):
        expected = oracle.accelerations(x, u, coin)
        q_ddot, multipliers = oracle.multiplier_form(x[:4], oracle.velocity(x, coin), u, coin)
        np.testing.assert_allclose(lagrange(x, u), expected, rtol=0, atol=ROUNDING)
        np.testing.assert_allclose(kane(x, u), expected, rtol=0, atol=ROUNDING)
        full = oracle.configuration_acceleration(x, u, coin)
        np.testing.assert_allclose(q_ddot, full, rtol=0, atol=ROUNDING)
        force = oracle.contact_force(x, u, coin)
        np.testing.assert_allclose(multipliers, force, rtol=0, atol=ROUNDING)


# Names and shapes


def test_states_and_controls_carry_the_authors_names(model: Any) -> None:
    assert tuple(model.state_names) == oracle.STATES
    assert tuple(model.control_names) == oracle.CONTROLS


def test_both_torques_are_limited_on_both_sides(model: Any) -> None:
    bounds = np.asarray(model.control_bounds)
    assert bounds.shape == (2, 2)
    assert np.isfinite(bounds).all()
    assert (bounds[:, 0] < 0).all()
    assert (bounds[:, 1] > 0).all()


# The equations of motion


def test_derived_motion_equals_the_closed_form(model: Any, samples: tuple[Array, Array]) -> None:
    for x, u in zip(*samples, strict=True):
        expected = oracle.state_derivative(x, u, COIN)
        np.testing.assert_allclose(model.f(x, u), expected, rtol=0, atol=ROUNDING)


def test_configuration_and_velocity_are_full_coordinates(
    model: Any, samples: tuple[Array, Array]
) -> None:
    for x in samples[0]:
        np.testing.assert_array_equal(model.configuration(x), x[:4])
        expected = oracle.velocity(x, COIN)
        np.testing.assert_allclose(model.velocity(x), expected, rtol=0, atol=ROUNDING)


def test_every_state_rolls_without_slip(model: Any, samples: tuple[Array, Array]) -> None:
    """Independent velocities are the state: the residual is rounding, not integration error."""
    for x, u in zip(*samples, strict=True):
        residual = np.asarray(model.constraint_residual(x, u))
        assert residual.shape == (2,)
        assert np.abs(residual).max() < ROUNDING  # [m/s]


def numbers(x: Array, u: Array, coin: Coin) -> dict[str, float]:
    """Every symbol's value on a closed-form motion, by the symbol's name."""
    named: dict[str, float] = {"m": coin.m, "R": coin.R, "g": 9.81}
    named |= dict(zip(oracle.CONTROLS, u, strict=True))
    names = oracle.STATES[:4]
    named |= dict(zip(names, x[:4], strict=True))
    rates = oracle.velocity(x, coin)
    named |= {f"{name}_dot": rate for name, rate in zip(names, rates, strict=True)}
    q_ddot = oracle.configuration_acceleration(x, u, coin)
    return named | {f"{name}_ddot": a for name, a in zip(names, q_ddot, strict=True)}


def unbalance(equations: Any, values: Mapping[str, float]) -> tuple[float, Array]:
    """Return the largest residual and the multipliers that make it smallest.

    Neither the order of the equations nor the sign of a side or of a multiplier matters.
    """
    sides = [equation.lhs - equation.rhs for equation in equations if equation != sp.true]
    symbols = sorted(set().union(*(side.free_symbols for side in sides)), key=str)
    unknown = [symbol for symbol in symbols if str(symbol).startswith("lambda")]
    known = {symbol: values[str(symbol)] for symbol in symbols if symbol not in unknown}
    A, b = sp.linear_eq_to_matrix([side.subs(known) for side in sides], unknown)
    matrix, target = np.array(A, dtype=float), np.array(b, dtype=float).ravel()
    multipliers = np.linalg.lstsq(matrix, target)[0]
    return float(np.abs(matrix @ multipliers - target).max()), multipliers


def test_printed_equations_hold_on_the_closed_form_motion(
    model: Any, samples: tuple[Array, Array]
) -> None:
    """One force per constraint: together they are the friction at the contact."""
    equations = model.equations()
    for x, u in list(zip(*samples, strict=True))[:10]:
        residual, multipliers = unbalance(equations, numbers(x, u, COIN))
        friction = np.linalg.norm(oracle.contact_force(x, u, COIN))
        assert residual < 1e-9  # [N] or [N m], of forces about 1
        assert multipliers.shape == (2,)
        assert np.linalg.norm(multipliers) == pytest.approx(friction, abs=1e-9)  # [N]


@pytest.mark.parametrize("name", ["x_ddot", "y_ddot", "psi_ddot", "phi_ddot", "drive", "steer"])
def test_printed_equations_refuse_another_motion(
    model: Any, samples: tuple[Array, Array], name: str
) -> None:
    values = numbers(samples[0][0], samples[1][0], COIN)
    values[name] += 1.0
    residual, _ = unbalance(model.equations(), values)
    assert residual > 1e-3  # the smallest inertia, m R^2 / 4, is 0.016 kg m^2


# Energy


def test_mass_matrix_is_the_closed_form(model: Any, samples: tuple[Array, Array]) -> None:
    for x in samples[0]:
        M = model.mass_matrix(x[:4])
        np.testing.assert_allclose(M, oracle.mass_matrix(COIN), rtol=0, atol=ROUNDING)
        np.testing.assert_array_equal(M, M.T)
        assert np.linalg.eigvalsh(M).min() > 0


def hessian(energy: Callable[[Array], float], size: int) -> Array:
    """Second central differences at rest; unit steps are exact for a quadratic form."""
    steps = np.eye(size)
    return np.array(
        [
            [(energy(a + b) - energy(a - b) - energy(b - a) + energy(-a - b)) / 4 for b in steps]
            for a in steps
        ]
    )


def rolling_energy(model: Any, q: Array, v: Array) -> float:
    """The model's kinetic energy in [J] at rates v = (psi_dot, phi_dot)."""
    return float(model.energy(np.concatenate([q, v]))[0])


def test_mass_matrix_is_the_hessian_of_the_kinetic_energy(
    model: Any, samples: tuple[Array, Array]
) -> None:
    """In full coordinates by Koenig's theorem, and along the rolling directions by the model."""
    full = hessian(lambda q_dot: oracle.kinetic_energy(q_dot, COIN), 4)
    for x in samples[0][:20]:
        q, M = x[:4], model.mass_matrix(x[:4])
        np.testing.assert_allclose(M, full, rtol=0, atol=ROUNDING)
        S = oracle.free_directions(q[2], COIN)
        rolling = hessian(partial(rolling_energy, model, q), 2)
        np.testing.assert_allclose(rolling, S.T @ M @ S, rtol=0, atol=ROUNDING)


def test_kinetic_energy_is_that_of_the_centre_and_the_spin(
    model: Any, samples: tuple[Array, Array]
) -> None:
    for x in samples[0]:
        expected = oracle.kinetic_energy(oracle.velocity(x, COIN), COIN)
        assert float(model.energy(x)[0]) == pytest.approx(expected, rel=1e-13, abs=1e-13)  # [J]


def test_gravity_does_no_work(model: Any, samples: tuple[Array, Array]) -> None:
    """The centre stays at the height R: the potential is the same everywhere."""
    potentials = [float(model.energy(x)[1]) for x in samples[0]]
    assert np.ptp(potentials) < ROUNDING  # [J]


def test_energy_grows_by_the_work_of_the_torques(model: Any) -> None:
    """dE/dt = drive phi_dot + steer psi_dot: friction at the contact does no work."""

    def slope(t: float, state: Array) -> Array:
        u = torques(t)
        return np.append(model.f(state[:6], u), u @ [state[5], state[4]])

    t = np.linspace(0.0, 20.0, 101)
    run = solve_ivp(slope, (0, 20), np.append(START, 0.0), "DOP853", t_eval=t, rtol=1e-9, atol=1e-9)
    energy = np.array([sum(map(float, model.energy(state))) for state in run.y[:6].T])
    kinetic = max(float(model.energy(state)[0]) for state in run.y[:6].T)
    assert np.ptp(run.y[6]) > 0.5 * kinetic  # the torques matter
    assert np.abs(energy - energy[0] - run.y[6]).max() < 1e-8 * kinetic  # ten times rtol


# Whole motions


def test_motion_equals_the_multiplier_simulation(model: Any) -> None:
    """Twenty seconds; the multiplier form drifts by 1e-11 m/s, over 20 s by less than 1e-9 m."""
    t = np.linspace(0.0, 20.0, 41)
    reduced = simulate(model.f, t, torques)
    full = oracle.multiplier_simulation(START, torques, t, COIN)
    np.testing.assert_allclose(reduced[:, :4], full[:, :4], rtol=0, atol=1e-8)
    velocities = np.array([model.velocity(x) for x in reduced])
    np.testing.assert_allclose(velocities, full[:, 4:], rtol=0, atol=1e-8)


def test_undriven_coin_rolls_on_a_circle(model: Any) -> None:
    """Radius R s / Omega, about a centre that stays."""
    t = np.linspace(0.0, 20.0, 41)
    path = simulate(model.f, t, lambda _: np.zeros(2))
    expected = oracle.undriven_circle(START, t, COIN)
    np.testing.assert_allclose(path, expected, rtol=0, atol=1e-10)  # 100 x atol + rtol |x|
    radius = COIN.R * START[5] / START[4]
    centre = START[:2] + radius * np.array([-np.sin(START[2]), np.cos(START[2])])
    distances = np.linalg.norm(path[:, :2] - centre, axis=1)
    np.testing.assert_allclose(distances, radius, rtol=0, atol=1e-10)  # [m]


@pytest.mark.parametrize("u", [(0.1, 0.03), (-0.2, 0.01), (0.3, 0.0)])
def test_constant_torques_follow_the_quadrature(model: Any, u: tuple[float, float]) -> None:
    held = np.array(u)
    end = simulate(model.f, np.array([0.0, 6.0]), lambda _: held)[-1]
    expected = oracle.constant_torque_motion(START, held, 6.0, COIN)
    np.testing.assert_allclose(end, expected, rtol=0, atol=1e-9)  # quadrature 1e-12, run 1e-11


def moved(x: Array, shift: Array, yaw: float) -> Array:
    """The same states seen after a turn by ``yaw`` about the origin and a shift in the plane."""
    c, s = np.cos(yaw), np.sin(yaw)
    image = np.array(x)
    image[..., :2] = x[..., :2] @ np.array([[c, s], [-s, c]]) + shift
    image[..., 2] += yaw
    return image


def walk(model: Any, start: Array, dt: float, steps: int) -> Array:
    """States after each of ``steps`` calls of ``model.step`` with slowly changing torques."""
    states = [start]
    for k in range(steps):
        states.append(np.asarray(model.step(states[-1], torques(k * dt), dt)))
    return np.array(states)


@pytest.mark.parametrize("yaw", [0.0, 0.4, 2.0, -3.0])
def test_the_floor_has_no_preferred_place_or_direction(model: Any, yaw: float) -> None:
    """Moving the start by a planar rigid motion moves the whole path by it."""
    shift = np.array([4.0, -7.0])
    path = walk(model, START, dt=0.05, steps=100)
    image = walk(model, moved(START, shift, yaw), dt=0.05, steps=100)
    assert difference(image, moved(path, shift, yaw)) < 1e-11  # 100 steps of rounding


def test_roll_angle_does_not_matter(model: Any, samples: tuple[Array, Array]) -> None:
    for x, u in zip(*samples, strict=True):
        turned = x + np.array([0.0, 0.0, 0.0, 1.7, 0.0, 0.0])
        np.testing.assert_allclose(model.f(turned, u), model.f(x, u), rtol=0, atol=ROUNDING)


# The integrator and the interface


def error_after(model: Any, dt: float, duration: float, expected: Array) -> float:
    """Error of constant-torque motion over ``duration`` in steps of ``dt``."""
    state, u = START, np.array([0.1, 0.03])
    for _ in range(round(duration / dt)):
        state = np.asarray(model.step(state, u, dt))
    return difference(state, expected)


def test_step_is_of_fourth_order(model: Any) -> None:
    """Halving the step divides the error by 16; neighbouring orders would give 8 or 32."""

    def f(x: Array, u: Array) -> Array:
        return oracle.state_derivative(x, u, COIN)

    exact = simulate(f, np.array([0.0, 2.0]), lambda _: np.array([0.1, 0.03]))[-1]
    errors = [error_after(model, dt, 2.0, exact) for dt in (0.1, 0.05, 0.025)]
    assert errors[-1] > 1e-10  # the reference, good to 1e-12, is far below
    for coarse, fine in pairwise(errors):
        assert 13 < coarse / fine < 20


def test_batches_equal_single_calls(model: Any, samples: tuple[Array, Array]) -> None:
    x, u = samples
    singly = np.array([model.f(*pair) for pair in zip(x, u, strict=True)])
    np.testing.assert_array_equal(model.f(x, u), singly)
    stepped = np.array([model.step(*pair, 0.05) for pair in zip(x, u, strict=True)])
    np.testing.assert_array_equal(model.step(x, u, 0.05), stepped)


@pytest.mark.parametrize("changes", [{"R": 0.3}, {"m": 2.0}, {"m": 0.4, "R": 0.5}])
def test_parameters_change_the_motion_as_the_closed_form_says(
    model: Any, samples: tuple[Array, Array], changes: dict[str, float]
) -> None:
    coin = Coin(**changes)
    built = kinolab.systems.get("rolling_disk", **changes).model()
    np.testing.assert_allclose(
        built.mass_matrix(START[:4]), oracle.mass_matrix(coin), rtol=0, atol=ROUNDING
    )
    expected = oracle.state_derivative(*samples, coin)
    np.testing.assert_allclose(built.f(*samples), expected, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(model.f(*samples, **changes), expected, rtol=0, atol=ROUNDING)


def test_a_parameter_of_one_call_is_forgotten_by_the_next(
    model: Any, samples: tuple[Array, Array]
) -> None:
    before = model.f(*samples)
    model.f(*samples, R=0.3)
    np.testing.assert_array_equal(model.f(*samples), before)
