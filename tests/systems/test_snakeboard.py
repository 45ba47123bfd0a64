"""The derived snakeboard against multipliers, its momentum equation and its gaits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

from kinolab import systems
from kinolab.dynamics import Model
from tests.oracles import snakeboard as oracle
from tests.oracles.snakeboard import Board, Gait

Array: TypeAlias = NDArray[np.float64]
Steering: TypeAlias = Callable[[float, Array], Array]  # time, state -> torques in [N m]

FREE = {"c_r": 0.0, "c_psi": 0.0, "c_phi": 0.0, "I_s": 0.0}  # the published machine
DRAG = {"c_r": 0.7, "c_psi": 0.01, "c_phi": 0.002, "I_s": 0.0}
BOARD = Board()
BRAKED = Board(**DRAG)
OTHER = {"m": 3.0, "l": 0.31, "J_r": 0.05, "J_w": 0.002} | DRAG
SPUN = OTHER | {"I_s": 7e-5}
ROUNDING = 1e-11  # relative to 1 plus the value; 1 / cos^2(1.2) = 7.6 magnifies the last digit
RATES = tuple(f"{name}_dot" for name in oracle.NAMES)

DRIVE, TURN, PARK = Gait(1, 1), Gait(2, 1), Gait(3, 2)
PERIOD = 2 * np.pi  # [s], of all three gaits


@pytest.fixture(scope="module")
def model() -> Model:
    return systems.get("snakeboard").model()


@pytest.fixture(scope="module")
def samples() -> tuple[Array, Array]:
    """One hundred random states (q of NAMES, p, psi_dot, phi_dot), (100, 8), and torques."""
    rng = np.random.default_rng(1994)
    x = rng.uniform(-3, 3, (100, 8))
    x[:, 4], x[:, 5] = rng.uniform(-1.2, 1.2, 100), rng.uniform(-2, 2, 100)
    return x, rng.uniform(-1, 1, (100, 2)) * [0.7, 0.06]


def named(x: Array, board: Board = BOARD) -> dict[str, float]:
    """Coordinates and rates by name, of x = (q of NAMES, p, psi_dot, phi_dot)."""
    rates = dict(zip(RATES, oracle.rates(x, board), strict=True))
    return dict(zip(oracle.NAMES, x, strict=False)) | rates


def state(model: Model, values: Mapping[str, float], **parameters: float) -> Array:
    """The model's state with these coordinates and rates; what is not named is 0.

    Whichever rates are its states, they follow from those of NAMES, in which it is linear.
    """
    free = [i for i, name in enumerate(model.state_names) if name in model.rate_names]
    x = np.array([values.get(name, 0.0) for name in model.state_names])
    x[free] = 0.0
    columns = rates_of(model, x + np.eye(len(x))[free], **parameters)
    wanted = [values.get(name, 0.0) for name in RATES]
    x[free] = np.linalg.lstsq(columns.T, np.array(wanted))[0]
    return x


def rates_of(model: Model, x: Array, **parameters: float) -> Array:
    """The rates of NAMES, shape (..., 5)."""
    columns = [model.rate_names.index(name) for name in RATES]
    return np.asarray(model.velocity(x, **parameters)[..., columns])


def accelerations_of(model: Model, x: Array, u: Array, **parameters: float) -> Array:
    """Second derivatives of NAMES, shape (5,): how the rates change along the flow.

    A central difference of sixth order in time, along x + t f: exact for rates linear in t.
    """
    h = 3e-4  # [s]; h^6 is below rounding over h
    slope, places = model.f(x, u, **parameters), np.array([-3, -2, -1, 1, 2, 3])
    rates = rates_of(model, x + h * places[:, None] * slope, **parameters)
    return np.asarray(np.array([-1, 9, -45, 45, -9, 1]) @ rates / (60 * h))


def pick(model: Model, x: Array, *names: str) -> Array:
    return np.asarray(x[..., [model.state_names.index(name) for name in names]])


def accelerations(x: Array, u: Array, board: Board) -> Array:
    """Second derivatives of NAMES by multipliers, shape (5,)."""
    spread, q_dot = oracle.SPREAD, oracle.rates(x, board)
    return oracle.multiplier_form(spread @ x[:5], spread @ q_dot, u, board)[:5]


def run(model: Model, start: Array, t: Array, u: Steering, **parameters: float) -> Array:
    """States at the times ``t``, shape (len(t), nx), by DOP853 near machine precision.

    Its error estimate lets the first steps from rest grow too long; 0.05 s keeps them to 1e-14.
    """

    def slope(time: float, x: Array) -> Array:
        return model.f(x, u(time, x), **parameters)

    span = (float(t[0]), float(t[-1]))
    done = solve_ivp(slope, span, start, "DOP853", t_eval=t, rtol=1e-12, atol=1e-13, max_step=0.05)
    return np.asarray(done.y.T)


def torques(model: Model, x: Array, wanted: ArrayLike, **parameters: float) -> Array:
    """Inverse dynamics: the torques that give (psi_ddot, phi_ddot); f is affine in them."""
    u = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    rates = pick(model, model.f(np.tile(x, (3, 1)), u, **parameters), "psi_dot", "phi_dot")
    return np.asarray(np.linalg.solve((rates[1:] - rates[0]).T, np.asarray(wanted) - rates[0]))


def prescribed(model: Model, shape: Callable[[float], Array], **parameters: float) -> Steering:
    """Torques that make (psi, phi) follow ``shape``, whose row 2 is the second derivative."""
    return lambda t, x: torques(model, x, shape(t)[2], **parameters)


# The oracles themselves


def test_the_momentum_equation_is_lagranges_along_the_free_direction() -> None:
    assert oracle.lagrange_residual() == 0


@pytest.mark.parametrize("board", [BOARD, BRAKED, Board(**OTHER)])
def test_multipliers_and_the_momentum_equation_agree(
    board: Board, samples: tuple[Array, Array]
) -> None:
    for x, u in zip(*samples, strict=True):
        q, q_dot = oracle.SPREAD @ x[:5], oracle.SPREAD @ oracle.rates(x, board)
        found = accelerations(x, u, board)
        expected = oracle.reduced_form(x, u, board)
        assert np.abs(oracle.constraint_matrix(q, board) @ q_dot).max() < 1e-12  # [m/s]
        np.testing.assert_allclose(found[3:], expected[6:], rtol=ROUNDING, atol=ROUNDING)


@pytest.mark.parametrize("board", [BOARD, BRAKED])
def test_both_oracles_follow_the_same_path_for_twenty_seconds(board: Board) -> None:
    t, start = np.linspace(0.0, 20.0, 41), driven_start()
    reduced = solve_ivp(
        lambda s, x: oracle.reduced_form(x, driving(s), board),
        (0.0, 20.0),
        start,
        "DOP853",
        t_eval=t,
        rtol=1e-12,
        atol=1e-13,
    ).y.T
    first = np.append(start[:5], oracle.rates(start, board))
    full = oracle.multiplier_simulation(first, driving, t, board)
    np.testing.assert_allclose(full[:, :5], reduced[:, :5], rtol=0, atol=1e-9)


def test_the_drive_gait_ends_where_it_is_known_to_end() -> None:
    """The figures are quoted to five places."""
    end = oracle.follow(DRIVE, np.array([0.0, 4 * PERIOD]), BOARD)[-1]
    np.testing.assert_allclose(end[:3], [-3.20325, 0.03246, -1.15059], rtol=0, atol=5e-6)


def driven_start() -> Array:
    """phi swings about 0.1 without drift: its rate starts at its lowest."""
    return np.array([0.3, -0.2, 0.5, 0.1, 0.1, 0.4, 0.8, -0.002 / (2 * BOARD.J_w * 1.3)])


def driving(t: float) -> Array:
    """Smooth torques in [N m]; phi swings by 0.46 rad where nothing brakes it."""
    return np.array([0.08 * np.sin(0.9 * t), 0.002 * np.sin(1.3 * t)])


# The equations of motion


def test_inputs_carry_the_names_of_the_joints(model: Model) -> None:
    assert tuple(model.control_names) == oracle.CONTROLS
    assert {*oracle.NAMES} <= {*model.state_names}


@pytest.mark.parametrize("parameters", [FREE, DRAG, OTHER])
def test_all_rates_roll_without_slip(
    model: Model, samples: tuple[Array, Array], parameters: dict[str, float]
) -> None:
    """Three free rates give all five, as the wheels of the oracle demand."""
    board = Board(**parameters)
    for x in samples[0]:
        start = state(model, named(x, board), **parameters)
        expected = oracle.rates(x, board)
        found = rates_of(model, start, **parameters)
        np.testing.assert_allclose(found, expected, rtol=ROUNDING, atol=ROUNDING)
        residual = model.constraint_residual(start, **parameters)
        assert np.abs(residual).max() < ROUNDING  # [m/s]


@pytest.mark.parametrize("parameters", [FREE, DRAG, OTHER, SPUN, {}])
def test_accelerations_are_those_of_the_multipliers(
    model: Model, samples: tuple[Array, Array], parameters: dict[str, float]
) -> None:
    """With the model's own parameters too, in which the wheels spin."""
    board = Board(**(model.system.parameter_values | parameters))
    for x, u in zip(*samples, strict=True):
        start, expected = state(model, named(x, board), **parameters), accelerations(x, u, board)
        slope = pick(model, model.f(start, u, **parameters), "psi_dot", "phi_dot")
        np.testing.assert_allclose(slope, expected[3:], rtol=ROUNDING, atol=ROUNDING)
        found = accelerations_of(model, start, u, **parameters)
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("parameters", [FREE, DRAG, DRAG | {"I_s": 7e-5}])
def test_twenty_driven_seconds_equal_the_multiplier_simulation(
    model: Model, parameters: dict[str, float]
) -> None:
    board, start, t = Board(**parameters), driven_start(), np.linspace(0.0, 20.0, 41)
    first = state(model, named(start, board), **parameters)
    path = run(model, first, t, lambda s, _: driving(s), **parameters)
    q = np.append(start[:5], oracle.rates(start, board))
    full = oracle.multiplier_simulation(q, driving, t, board)
    np.testing.assert_allclose(pick(model, path, *oracle.NAMES), full[:, :5], rtol=0, atol=1e-9)
    assert np.ptp(full[:, 0]) > 0.5  # [m]; the torques move the board
    assert np.abs(full[:, 4]).max() < 1.2  # [rad]; far from where the wheel axles coincide


@pytest.mark.parametrize("parameters", [FREE, SPUN, {}])
def test_kinetic_energy_is_that_of_the_bodies(
    model: Model, samples: tuple[Array, Array], parameters: dict[str, float]
) -> None:
    board = Board(**(model.system.parameter_values | parameters))
    for x in samples[0]:
        q, q_dot = oracle.SPREAD @ x[:5], oracle.SPREAD @ oracle.rates(x, board)
        start = state(model, named(x, board), **parameters)
        kinetic, potential = model.energy(start, **parameters)
        assert kinetic == pytest.approx(oracle.kinetic_energy(q, q_dot, board), rel=1e-12)
        assert potential == pytest.approx(0.0, abs=1e-12)  # [J]; it rides on a level floor


# Energy and what is conserved


def dissipated(x: Array, board: Board) -> float:
    """Power in [W] that the drags take: each pair rolls at v_x / cos phi."""
    rates = oracle.rates(x, board)
    rolling = 2 * (rates[:2] @ rates[:2]) / np.cos(x[4]) ** 2
    return float(board.c_r * rolling + board.c_psi * rates[3] ** 2 + board.c_phi * rates[4] ** 2)


@pytest.mark.parametrize("parameters", [FREE, DRAG])
def test_energy_changes_by_work_and_drag(model: Model, parameters: dict[str, float]) -> None:
    """The wheels do no work sideways; the work is integrated beside the multiplier motion."""
    board, start, t = Board(**parameters), driven_start(), np.linspace(0.0, 10.0, 11)

    def slope(s: float, z: Array) -> Array:
        x, u = z[:8], driving(s)
        return np.append(oracle.reduced_form(x, u, board), u @ x[6:8] - dissipated(x, board))

    done = solve_ivp(
        slope, (0.0, 10.0), np.append(start, 0.0), "DOP853", t_eval=t, rtol=1e-12, atol=1e-13
    )
    first = state(model, named(start, board), **parameters)
    path = run(model, first, t, lambda s, _: driving(s), **parameters)
    energy = np.array([sum(model.energy(x, **parameters)) for x in path])
    np.testing.assert_allclose(energy - energy[0], done.y[8], rtol=0, atol=1e-10)  # [J], of 0.1
    assert np.ptp(done.y[8]) > 0.02


def test_undriven_board_keeps_energy_rotor_momentum_and_steering_rate(model: Model) -> None:
    """The rotor's spin in the world is a symmetry that the wheels do not see; so is phi."""
    x = np.array([0.0, 0.0, 0.4, 0.0, -0.8, -1.5, 2.0, 0.15])
    path = run(model, state(model, named(x)), np.linspace(0, 10, 21), still, **FREE)
    velocity = rates_of(model, path)
    spin = velocity[:, 2] + velocity[:, 3]
    energy = np.array([sum(model.energy(s, **FREE)) for s in path])
    assert np.ptp(spin) < 1e-10  # [rad/s]
    assert np.ptp(energy) < 1e-10  # [J], of 0.5
    np.testing.assert_allclose(pick(model, path, "phi_dot"), 0.15, rtol=0, atol=1e-12)
    assert np.ptp(velocity[:, 2]) > 0.1  # [rad/s]; the parts do exchange momentum


def still(t: float, x: Array) -> Array:  # noqa: ARG001
    return np.zeros(2)


def test_locked_rotor_leaves_the_speed_over_the_cosine_of_the_steering(model: Model) -> None:
    """With psi_dot = 0, p_dot = -tan(phi) phi_dot p, so p / cos phi stays."""
    x = np.array([0.0, 0.0, 0.0, 0.3, 0.0, -2.0, 0.0, 0.9 * 0.8])
    steer = prescribed(model, steering_swing, **FREE)
    path = run(model, state(model, named(x)), np.linspace(0, 10, 21), steer, **FREE)
    theta, phi = pick(model, path, "theta", "phi").T
    velocity = rates_of(model, path)
    forward = velocity[:, 0] * np.cos(theta) + velocity[:, 1] * np.sin(theta)
    np.testing.assert_allclose(forward / np.cos(phi), forward[0], rtol=0, atol=1e-10)  # [m/s]
    assert np.ptp(phi) > 1.5


def steering_swing(t: float) -> Array:
    """(psi, phi) = (0.3, 0.9 sin 0.8 t) and its derivatives, shape (3, 2)."""
    sine, cosine = np.sin(0.8 * t), np.cos(0.8 * t)
    phi = 0.9 * np.array([sine, 0.8 * cosine, -(0.8**2) * sine])
    return np.column_stack([[0.3, 0.0, 0.0], phi])


def test_straight_coasting_decays_at_the_rate_of_both_pairs(model: Model) -> None:
    """m v_dot = -2 c_r v."""
    x = state(model, {"x_dot": 1.5})
    for _ in range(100):
        x = model.step(x, [0, 0], 0.02, **DRAG)
    decay = 2 * BRAKED.c_r / BRAKED.m
    expected = 1.5 * (1 - np.exp(-2.0 * decay)) / decay
    assert pick(model, x, "x")[0] == pytest.approx(expected, abs=1e-10)  # [m]


# Gaits

GAITS = {"drive": DRIVE, "turn": TURN, "park": PARK}
HALF_PERIODS = np.linspace(0.0, 4 * PERIOD, 9)


@pytest.fixture(scope="module")
def driven(model: Model) -> dict[str, Array]:
    """States of the free board at every half period of four of each gait, driven by torques."""
    return {name: driven_path(model, gait) for name, gait in GAITS.items()}


def driven_path(model: Model, gait: Gait) -> Array:
    start = np.array([0, 0, 0, 0, 0, 0, *gait.shape(0.0)[1]])
    steer = prescribed(model, gait.shape, **FREE)
    return run(model, state(model, named(start)), HALF_PERIODS, steer, **FREE)


@pytest.mark.parametrize("name", GAITS)
def test_driven_gait_goes_where_the_momentum_equation_says(
    model: Model, driven: dict[str, Array], name: str
) -> None:
    """Torques by inverse dynamics; the board, not the torques, is what is compared."""
    gait, path = GAITS[name], driven[name]
    expected = oracle.follow(gait, HALF_PERIODS, BOARD)[:, :3]
    np.testing.assert_allclose(pick(model, path, "x", "y", "theta"), expected, rtol=0, atol=1e-9)
    shape = np.array([gait.shape(s)[0] for s in HALF_PERIODS])
    np.testing.assert_allclose(pick(model, path, "psi", "phi"), shape, rtol=0, atol=1e-9)


def after(model: Model, path: Array, periods: int) -> Array:
    """(x, y, theta) after some periods of a gait."""
    return pick(model, path[2 * periods], "x", "y", "theta")


def test_the_drive_gait_drives(model: Model, driven: dict[str, Array]) -> None:
    """1:1, four periods: 3.2 m backwards, the figures being quoted to five places."""
    end = after(model, driven["drive"], 4)
    np.testing.assert_allclose(end, [-3.20325, 0.03246, -1.15059], rtol=0, atol=1e-5)


def test_the_turning_gait_turns_on_the_spot(model: Model, driven: dict[str, Array]) -> None:
    """2:1: 0.579 rad in each period, all of them about one point within the wheelbase."""
    first, fourth = (after(model, driven["turn"], n) for n in (1, 4))
    assert fourth[2] == pytest.approx(4 * first[2], abs=1e-9)
    assert first[2] == pytest.approx(0.57929, abs=1e-5)  # [rad]
    radius = np.linalg.norm(first[:2]) / (2 * np.sin(first[2] / 2))  # of the circle of poses
    assert radius < BOARD.l / 4
    assert np.linalg.norm(fourth[:2]) < 2 * radius


def test_the_parking_gait_moves_sideways_only(model: Model, driven: dict[str, Array]) -> None:
    """3:2: 7 cm to the right in each period, neither forwards nor turned."""
    first, fourth = (after(model, driven["park"], n) for n in (1, 4))
    np.testing.assert_allclose(first[[0, 2]], 0.0, atol=1e-9)
    np.testing.assert_allclose(fourth[[0, 2]], 0.0, atol=1e-9)
    assert first[1] == pytest.approx(-0.07067, abs=1e-5)  # [m]
    assert fourth[1] == pytest.approx(4 * first[1], abs=1e-9)


# Rest to rest


def smooth(t: float, change: float) -> Array:
    """A value that goes from 0 to ``change`` in 1 s, and its derivatives: rest to rest."""
    value = t**3 * (10 - 15 * t + 6 * t**2)
    slope = 30 * t**2 * (1 - t) ** 2
    return change * np.array([value, slope, 60 * t * (1 - t) * (1 - 2 * t)])


def leg(model: Model, x: Array, change: ArrayLike) -> Array:
    """The state after (psi, phi) changed smoothly within 1 s, driven by torques."""
    amount = np.asarray(change, dtype=float)
    steer = prescribed(model, lambda t: smooth(t, 1.0)[:, None] * amount, **FREE)
    return run(model, x, np.array([0.0, 1.0]), steer, **FREE)[-1]


def speed(model: Model, x: Array) -> float:
    """Largest of all rates, in [m/s] or [rad/s]."""
    return float(np.abs(rates_of(model, x)).max())


def test_steering_alone_moves_nothing_else(model: Model) -> None:
    start = state(model, {"x": 1.0, "theta": 0.7, "phi": -0.4, "psi": 0.2})
    end = leg(model, start, (0.0, 0.9))
    np.testing.assert_allclose(
        pick(model, end, *oracle.NAMES), [1.0, 0.0, 0.7, 0.2, 0.5], rtol=0, atol=1e-10
    )
    assert speed(model, end) < 1e-10


@pytest.mark.parametrize("phi", [0.2, -0.6, 1.1])
def test_rotor_alone_swings_the_board_about_the_meeting_of_its_axles(
    model: Model, phi: float
) -> None:
    """A decoupling vector field (Bullo and Lewis): any speed along it, rest to rest."""
    start = state(model, {"x": 1.0, "y": -2.0, "theta": 0.7, "phi": phi})
    end = leg(model, start, (2.5, 0.0))
    expected = oracle.swing(np.array([1.0, -2.0, 0.7]), phi, 2.5, BOARD)
    np.testing.assert_allclose(pick(model, end, "x", "y", "theta"), expected, rtol=0, atol=1e-10)
    np.testing.assert_allclose(pick(model, end, "psi", "phi"), [2.5, phi], rtol=0, atol=1e-10)
    assert speed(model, end) < 1e-10
    assert np.abs(model.constraint_residual(end)).max() < 1e-12


def test_a_chain_of_swings_reaches_the_pose_of_the_closed_form(model: Model) -> None:
    """Steer, swing, steer, swing …: a plan from rest to rest without solving any equation."""
    pose, x, phi = np.zeros(3), model.rest(), 0.0
    for steering, turn in [(0.8, 2.0), (-0.8, -3.0), (0.5, 1.5), (-1.1, 2.0)]:
        x = leg(model, leg(model, x, (0.0, steering - phi)), (turn, 0.0))
        pose, phi = oracle.swing(pose, steering, turn, BOARD), steering
    np.testing.assert_allclose(pick(model, x, "x", "y", "theta"), pose, rtol=0, atol=1e-9)
    assert speed(model, x) < 1e-9
    assert np.linalg.norm(pose) > 0.1


def test_moving_both_joints_at_once_leaves_the_board_rolling(model: Model) -> None:
    """p_dot = 2 J_r cos^2(phi) phi_dot psi_dot: only one joint at a time goes rest to rest."""
    end = leg(model, model.rest(), (1.0, 1.0))
    rates = rates_of(model, end)
    assert np.linalg.norm(rates[:2]) > 0.01  # [m/s]
    np.testing.assert_allclose(rates[3:], 0.0, atol=1e-10)
