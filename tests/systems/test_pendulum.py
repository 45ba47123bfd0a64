"""The derived pendulum against oracles that know nothing of the derivation."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import kinolab.systems
from tests.conftest import Solver
from tests.oracles import pendulum as oracle
from tests.oracles.pendulum import Pendulum, SwingUp

Array = NDArray[np.float64]

PENDULUM = Pendulum()
OTHER = Pendulum(m=0.7, l=1.6, g=3.7)
FREE = np.zeros(1)
AMPLITUDES = [0.1, 1.0, np.pi / 2, 2.5, 3.0]  # [rad]
ROUNDING = 1e-12  # SI; values reach 20, a few operations lose a few units in the 16th digit


@pytest.fixture(scope="module")
def model() -> Any:
    return kinolab.systems.get("pendulum").model()


@pytest.fixture(scope="module")
def samples() -> tuple[Array, Array]:
    """One hundred random states (100, 2) and torques (100, 1)."""
    rng = np.random.default_rng(1976)
    return rng.uniform(-4, 4, (100, 2)), rng.uniform(-5, 5, (100, 1))


def on_circle(x: Array) -> Array:
    """(sin theta, cos theta, theta_dot): equal for states that differ by whole turns."""
    x = np.asarray(x)
    return np.stack([np.sin(x[..., 0]), np.cos(x[..., 0]), x[..., 1]], axis=-1)


# The oracles themselves


@pytest.mark.parametrize("pendulum", [PENDULUM, OTHER])
def test_lagrange_and_kane_agree_with_the_closed_form(
    pendulum: Pendulum, samples: tuple[Array, Array]
) -> None:
    lagrange = oracle.lagrange_acceleration(pendulum)
    kane = oracle.kane_acceleration(pendulum)
    for x, u in zip(*samples, strict=True):
        expected = oracle.state_derivative(x, u, pendulum)[1]
        assert lagrange(x, u) == pytest.approx(expected, rel=0, abs=ROUNDING)
        assert kane(x, u) == pytest.approx(expected, rel=0, abs=ROUNDING)


def test_a_quarter_turn_swings_eighteen_percent_slower_than_small_swings() -> None:
    """2 K(1/2) / pi, with K(1/2) = Gamma(1/4)^2 / (4 sqrt(pi)) = 1.854074677301372."""
    small = 2 * np.pi / PENDULUM.small_frequency
    expected = 2 * 1.854074677301372 / np.pi
    assert oracle.period(np.pi / 2, PENDULUM) / small == pytest.approx(expected, rel=1e-14)


# Names and shapes


def test_states_and_controls_carry_the_authors_names(model: Any) -> None:
    assert tuple(model.state_names) == oracle.STATES
    assert tuple(model.control_names) == oracle.CONTROLS


def test_the_torque_is_limited_on_both_sides(model: Any) -> None:
    bounds = np.asarray(model.control_bounds)
    assert bounds.shape == (1, 2)
    assert np.isfinite(bounds).all()
    assert bounds[0, 0] < 0 < bounds[0, 1]


# The equations of motion


def test_derived_motion_equals_the_closed_form(model: Any, samples: tuple[Array, Array]) -> None:
    for x, u in zip(*samples, strict=True):
        expected = oracle.state_derivative(x, u, PENDULUM)
        np.testing.assert_allclose(model.f(x, u), expected, rtol=0, atol=ROUNDING)


def test_configuration_and_velocity_split_the_state(
    model: Any, samples: tuple[Array, Array]
) -> None:
    for x in samples[0]:
        np.testing.assert_array_equal(model.configuration(x), x[:1])
        np.testing.assert_array_equal(model.velocity(x), x[1:])


def test_the_angle_alone_needs_no_constraint(model: Any) -> None:
    assert np.asarray(model.constraint_residual(np.array([0.3, 0.7]), FREE)).size == 0


def unbalance(model: Any, x: Array, u: Array, acceleration: float) -> float:
    """Largest residual of the printed equations, whatever their order or sign."""
    values = {"m": PENDULUM.m, "l": PENDULUM.l, "g": PENDULUM.g, "torque": u[0]}
    values |= {"theta": x[0], "theta_dot": x[1], "theta_ddot": acceleration}
    sides = [equation.lhs - equation.rhs for equation in model.equations() if equation != sp.true]
    return max(
        abs(float(side.subs({symbol: values[str(symbol)] for symbol in side.free_symbols})))
        for side in sides
    )


def test_printed_equation_holds_on_the_closed_form_motion(
    model: Any, samples: tuple[Array, Array]
) -> None:
    for x, u in zip(*samples, strict=True):
        acceleration = oracle.state_derivative(x, u, PENDULUM)[1]
        assert unbalance(model, x, u, acceleration) < 1e-9  # [N m], of moments about 10
        assert unbalance(model, x, u, acceleration + 1.0) > 0.1  # the inertia is 1 kg m^2


# Energy


def test_mass_matrix_is_the_inertia_about_the_pivot(
    model: Any, samples: tuple[Array, Array]
) -> None:
    for x in samples[0]:
        M = np.asarray(model.mass_matrix(x[:1]))
        np.testing.assert_allclose(M, oracle.mass_matrix(PENDULUM), rtol=0, atol=ROUNDING)
        assert M[0, 0] > 0


def test_mass_matrix_is_the_hessian_of_the_kinetic_energy(
    model: Any, samples: tuple[Array, Array]
) -> None:
    """Second central differences; a unit step is exact for a quadratic form."""
    by_hand = sum(oracle.kinetic_energy(rate, PENDULUM) for rate in (-1.0, 1.0))
    for x in samples[0]:
        M = float(model.mass_matrix(x[:1])[0, 0])
        below, at, above = (float(model.energy(np.array([x[0], v]))[0]) for v in (-1.0, 0.0, 1.0))
        assert above - 2 * at + below == pytest.approx(M, rel=0, abs=ROUNDING)
        assert by_hand == pytest.approx(M, rel=0, abs=ROUNDING)


def test_energies_are_those_of_a_point_mass(model: Any, samples: tuple[Array, Array]) -> None:
    """Heights are compared with the hanging position, wherever the model counts from."""
    lowest = float(model.energy(np.zeros(2))[1])
    for x in samples[0]:
        kinetic, potential = map(float, model.energy(x))
        assert kinetic == pytest.approx(oracle.kinetic_energy(x[1], PENDULUM), abs=ROUNDING)
        expected = oracle.potential_energy(x[0], PENDULUM)
        assert potential - lowest == pytest.approx(expected, abs=ROUNDING)


def test_energy_grows_by_the_work_of_the_torque(model: Any) -> None:
    """dE/dt = torque theta_dot, along swings that pass over the top and back."""

    def torque(t: float) -> Array:
        return np.array([4.0 * np.sin(1.3 * t)])

    def slope(t: float, state: Array) -> Array:
        return np.append(model.f(state[:2], torque(t)), torque(t)[0] * state[1])

    t = np.linspace(0.0, 20.0, 101)
    start = np.array([1.0, 0.5, 0.0])
    run = solve_ivp(slope, (0, 20), start, "DOP853", t_eval=t, rtol=1e-10, atol=1e-10)
    energy = np.array([sum(map(float, model.energy(state))) for state in run.y[:2].T])
    assert np.ptp(run.y[2]) > PENDULUM.weight_moment  # the torque matters
    assert np.abs(energy - energy[0] - run.y[2]).max() < 1e-8 * np.ptp(energy)


# Whole motions


@pytest.mark.parametrize("amplitude", AMPLITUDES)
@pytest.mark.parametrize("pendulum", [PENDULUM, OTHER])
def test_period_is_the_complete_elliptic_integral(
    model: Any, pendulum: Pendulum, amplitude: float
) -> None:
    """Twice through the bottom in the same sense; near the top errors of 1e-12 grow to 1e-10."""
    changes = {"m": pendulum.m, "l": pendulum.l, "g": pendulum.g}
    expected = oracle.period(amplitude, pendulum)

    def falling(_: float, x: Array) -> float:
        return float(x[0])

    falling.direction = -1.0  # type: ignore[attr-defined]
    run = solve_ivp(
        lambda _, x: model.f(x, FREE, **changes),
        (0.0, 1.5 * expected),
        [amplitude, 0.0],
        "DOP853",
        events=falling,
        rtol=1e-12,
        atol=1e-13,
    )
    first, second = np.concatenate(run.t_events or [])
    assert second - first == pytest.approx(expected, rel=0, abs=1e-8)  # [s]


@pytest.mark.parametrize("amplitude", AMPLITUDES)
def test_swing_follows_jacobis_elliptic_functions(model: Any, amplitude: float) -> None:
    t = np.linspace(0.0, oracle.period(amplitude, PENDULUM), 33)
    run = solve_ivp(
        lambda _, x: model.f(x, FREE),
        (0.0, t[-1]),
        [amplitude, 0.0],
        "DOP853",
        t_eval=t,
        rtol=1e-12,
        atol=1e-13,
    )
    expected = oracle.swing(amplitude, t, PENDULUM)
    np.testing.assert_allclose(run.y.T, expected, rtol=0, atol=1e-8)  # measured 1e-10 at 3 rad


def test_left_and_right_are_alike(model: Any, samples: tuple[Array, Array]) -> None:
    for x, u in zip(*samples, strict=True):
        np.testing.assert_allclose(model.f(-x, -u), -model.f(x, u), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("turns", [-2, 1, 3])
def test_whole_turns_do_not_matter(model: Any, samples: tuple[Array, Array], turns: int) -> None:
    """The angle lives on a circle; adding 6 pi costs 2e-15 rad of rounding, times g / l."""
    x, u = samples
    turned = x + np.array([2 * np.pi * turns, 0.0])
    np.testing.assert_allclose(model.f(turned, u), model.f(x, u), rtol=0, atol=ROUNDING)
    after, plain = model.step(turned, u, 0.02), model.step(x, u, 0.02)
    np.testing.assert_allclose(on_circle(after), on_circle(plain), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("theta", [0.0, np.pi])
def test_hanging_and_upright_are_the_equilibria(model: Any, theta: float) -> None:
    rest = model.f(np.array([theta, 0.0]), FREE)
    np.testing.assert_allclose(rest, 0.0, rtol=0, atol=ROUNDING)


# Swinging up with a motor that is too weak to lift the rod

LIMIT = 5.0  # [N m]; the weight's moment is 9.81 N m
SWING_UP = SwingUp(LIMIT, angle=0.1, rate=0.2)  # the goal of the scenario
LIFT = PENDULUM.weight_moment * (1 + np.cos(SWING_UP.angle))  # [J]: the goal's least energy


@pytest.fixture(scope="module")
def fastest() -> tuple[float, float]:
    """Least time in [s] and the direction of its first costate."""
    return oracle.fastest_swing_up(SWING_UP)


def test_the_motor_is_the_one_that_these_bounds_are_for(model: Any) -> None:
    np.testing.assert_array_equal(model.control_bounds, [[-LIMIT, LIMIT]])


def test_the_motor_holds_the_rod_only_near_the_vertical(model: Any) -> None:
    """m g l |sin theta| <= limit: within 31 degrees of hanging or upright; at 90 it falls."""
    edge = float(np.arcsin(LIMIT / PENDULUM.weight_moment))
    for theta in np.linspace(edge + 1e-3, np.pi - edge - 1e-3, 21):
        for side in (-1, 1):
            helped = side * float(model.f(np.array([side * theta, 0.0]), [side * LIMIT])[1])
            assert helped < 0  # [rad/s^2]: even the full torque does not keep it from falling
    for theta in (edge, np.pi - edge):
        assert float(model.f(np.array([theta, 0.0]), [LIMIT])[1]) == pytest.approx(0, abs=1e-12)


def test_one_push_lifts_no_higher_than_its_work(model: Any) -> None:
    """From rest the full torque turns back where limit theta = m g l (1 - cos theta)."""

    def gained(theta: float) -> float:
        return LIMIT * theta - oracle.potential_energy(theta, PENDULUM)

    def slowing(_: float, x: Array) -> float:
        return float(x[1])

    slowing.terminal, slowing.direction = True, -1.0  # type: ignore[attr-defined]
    push = np.array([LIMIT])
    run = solve_ivp(
        lambda _, x: model.f(x, push),
        (0, 5),
        [0, 0],
        "DOP853",
        events=slowing,
        rtol=1e-11,
        atol=1e-12,
    )
    highest = brentq(gained, 0.5, np.pi / 2)
    assert run.y[0, -1] == pytest.approx(highest, abs=1e-8)  # [rad]
    assert highest < np.pi / 2


def test_the_fastest_swing_up_takes_longer_than_its_energy(fastest: tuple[float, float]) -> None:
    """The energy's bound of 1.25 s ignores gravity; Pontryagin's principle gives 2.29 s."""
    bound = oracle.energy_time(LIFT, LIMIT, PENDULUM)
    assert bound == pytest.approx(1.2513, abs=1e-4)
    assert bound < fastest[0]


def test_no_bang_bang_motion_with_two_switches_is_faster(fastest: tuple[float, float]) -> None:
    """A search by hand over both moments, in steps of 0.02 s; it knows no costate."""
    moments, dt = np.arange(0.0, 2.4, 0.02), 0.005
    one, two = (grid.ravel() for grid in np.meshgrid(moments, moments))
    x, best = np.zeros((2, len(one))), np.inf
    for k in range(480):
        u = np.where((k * dt >= one) & (k * dt < one + two), -LIMIT, LIMIT)
        x[1] += dt * (u - PENDULUM.weight_moment * np.sin(x[0])) / PENDULUM.inertia
        x[0] += dt * x[1]
        if SWING_UP.reached(x).any():
            best = (k + 1) * dt
            break
    assert best == pytest.approx(fastest[0], abs=0.03)  # [s]: the grid's, and the coarse steps'


def test_the_fastest_swing_up_arrives(model: Any, fastest: tuple[float, float]) -> None:
    """The bound is met, not only kept: forwards, back, forwards."""
    end, direction = fastest
    torque, switches = oracle.switching_times(SWING_UP, direction, end)
    assert len(switches) == 2
    x = np.zeros(2)
    for begin, stop in pairwise([0.0, *switches, end]):
        held = np.array([torque])
        run = solve_ivp(
            lambda _, x, held=held: model.f(x, held),
            (begin, stop),
            x,
            "DOP853",
            rtol=1e-11,
            atol=1e-12,
        )
        x, torque = run.y[:, -1], -torque
    late = replace(SWING_UP, angle=0.101, rate=0.21)  # what 1 ms at 0.2 rad/s, 6 rad/s^2 changes
    assert late.reached(x)


def test_the_plan_upright_is_not_faster_than_the_fastest(
    solved: Solver, fastest: tuple[float, float]
) -> None:
    """The girder, held inputs and the search can only lengthen it."""
    plan = solved("pendulum_swingup").trajectory
    assert SWING_UP.reached(plan.x[-1])
    assert plan.duration >= fastest[0] - 2e-3  # [s]: the oracle is sharp to 1e-3 s
    assert plan.duration >= oracle.energy_time(LIFT, LIMIT, PENDULUM)


def test_the_plan_upright_swings_back_for_the_work_it_lacks(solved: Solver) -> None:
    """The motor needs 3.9 rad for the lift; the way up is 3.1 rad."""
    theta = solved("pendulum_swingup").trajectory.x[:, 0]
    assert np.abs(np.diff(theta)).sum() >= LIFT / LIMIT > np.pi
    assert theta.min() < 0 < theta.max()


# The integrator and the interface


def error_after(model: Any, dt: float, start: Array, duration: float, expected: Array) -> float:
    state = start
    for _ in range(round(duration / dt)):
        state = np.asarray(model.step(state, np.array([1.5]), dt))
    return float(np.abs(on_circle(state) - on_circle(expected)).max())


def test_step_is_of_fourth_order(model: Any) -> None:
    """Halving the step divides the error by 16; neighbouring orders would give 8 or 32."""
    start, u = np.array([1.0, 0.5]), np.array([1.5])
    run = solve_ivp(
        lambda _, x: oracle.state_derivative(x, u, PENDULUM),
        (0.0, 2.0),
        start,
        "DOP853",
        rtol=1e-12,
        atol=1e-13,
    )
    exact = run.y[:, -1]
    errors = [error_after(model, dt, start, 2.0, exact) for dt in (0.02, 0.01, 0.005)]
    assert errors[-1] > 1e-10  # the reference, good to 1e-12, is far below
    for coarse, fine in pairwise(errors):
        assert 13 < coarse / fine < 20


def test_batches_equal_single_calls(model: Any, samples: tuple[Array, Array]) -> None:
    x, u = samples
    singly = np.array([model.f(*pair) for pair in zip(x, u, strict=True)])
    np.testing.assert_array_equal(model.f(x, u), singly)
    stepped = np.array([model.step(*pair, 0.02) for pair in zip(x, u, strict=True)])
    np.testing.assert_array_equal(model.step(x, u, 0.02), stepped)


@pytest.mark.parametrize("changes", [{"l": 0.6}, {"m": 2.5}, {"g": 1.62}, {"m": 0.7, "l": 1.6}])
def test_parameters_change_the_motion_as_the_closed_form_says(
    model: Any, samples: tuple[Array, Array], changes: dict[str, float]
) -> None:
    pendulum = Pendulum(**changes)
    built = kinolab.systems.get("pendulum", **changes).model()
    M = built.mass_matrix(np.zeros(1))
    np.testing.assert_allclose(M, oracle.mass_matrix(pendulum), rtol=0, atol=ROUNDING)
    expected = oracle.state_derivative(*samples, pendulum)
    np.testing.assert_allclose(built.f(*samples), expected, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(model.f(*samples, **changes), expected, rtol=0, atol=ROUNDING)


def test_a_parameter_of_one_call_is_forgotten_by_the_next(
    model: Any, samples: tuple[Array, Array]
) -> None:
    before = model.f(*samples)
    model.f(*samples, l=0.5)
    np.testing.assert_array_equal(model.f(*samples), before)
