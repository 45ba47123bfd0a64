"""The derived differential drive against Newton's and Euler's laws, and its flat output."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from kinolab import systems
from tests.oracles import vehicles as oracle
from tests.oracles.vehicles import DiffDrive

Array = NDArray[np.float64]

ROBOT = DiffDrive()
OTHER = DiffDrive(m=31.0, I_z=2.1, I_w=0.08, r=0.16, b=0.52, c_w=0.3)
FREE = replace(ROBOT, c_w=0.0)
START = np.array([0.3, -0.2, 0.5, 1.0, -2.0, 3.0, 5.0])  # turning left while rolling forward


@pytest.fixture(scope="module")
def model() -> Any:
    return systems.get("diff_drive").model()


@pytest.fixture(scope="module")
def samples() -> tuple[Array, Array]:
    """One hundred random states (100, 7) and torques (100, 2)."""
    rng = np.random.default_rng(1994)
    return rng.uniform(-4, 4, (100, 7)), rng.uniform(-1, 1, (100, 2))


def ordered(model: Any, x: Array) -> Array:
    """States in the oracle's order as the model wants them."""
    return x[..., [oracle.DRIVE_STATES.index(name) for name in model.state_names]]


def restored(model: Any, x: Array) -> Array:
    """States, or their derivatives, of the model in the oracle's order."""
    return x[..., [model.state_names.index(name) for name in oracle.DRIVE_STATES]]


def derivative(model: Any, x: Array, u: Array, robot: DiffDrive) -> Array:
    """Return the model's x_dot for a state in the oracle's order, in that order."""
    return restored(model, np.asarray(model.f(ordered(model, x), u, **asdict(robot))))


def simulate(model: Any, start: Array, inputs: Any, t: Array, robot: DiffDrive) -> Array:
    """States at times ``t`` in the oracle's order, shape (len(t), 7), by DOP853."""
    run = solve_ivp(
        lambda s, x: derivative(model, x, inputs(s), robot),
        (float(t[0]), float(t[-1])),
        start,
        "DOP853",
        t_eval=t,
        rtol=1e-12,
        atol=1e-12,
    )
    return np.asarray(run.y.T, dtype=np.float64)


def test_states_and_controls_carry_the_authors_names(model: Any) -> None:
    assert sorted(model.state_names) == sorted(oracle.DRIVE_STATES)
    assert tuple(model.control_names) == oracle.DRIVE_CONTROLS


# The equations of motion


@pytest.mark.parametrize("robot", [ROBOT, OTHER])
def test_multipliers_agree_with_newton_and_euler(
    samples: tuple[Array, Array], robot: DiffDrive
) -> None:
    """The two oracles, derived apart from each other."""
    for x, u in zip(*samples, strict=True):
        expected = oracle.drive_derivative(x, u, robot)[5:]
        found = oracle.drive_by_multipliers(x, u, robot)
        assert np.abs(found - expected).max() < 1e-11 * np.abs(expected).max()


@pytest.mark.parametrize("robot", [ROBOT, OTHER, FREE])
def test_derived_motion_equals_the_closed_form(
    model: Any, samples: tuple[Array, Array], robot: DiffDrive
) -> None:
    for x, u in zip(*samples, strict=True):
        expected = oracle.drive_derivative(x, u, robot)
        found = derivative(model, x, u, robot)
        assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("robot", [ROBOT, OTHER])
def test_energy_is_that_of_the_whole_and_of_the_spinning_wheels(
    model: Any, samples: tuple[Array, Array], robot: DiffDrive
) -> None:
    for x in samples[0]:
        kinetic, _ = model.energy(ordered(model, x), **asdict(robot))
        assert float(kinetic) == pytest.approx(oracle.drive_energy(x, robot), rel=1e-12)


def test_energy_changes_by_the_work_of_motors_and_drag(model: Any) -> None:
    def torques(t: float) -> Array:
        return np.array([0.5 * np.sin(2 * t), 0.4 * np.cos(3 * t)])

    def slope(t: float, both: Array) -> Array:
        x, u = both[:7], torques(t)
        power = (u - ROBOT.c_w * x[5:]) @ x[5:]
        return np.append(derivative(model, x, u, ROBOT), power)

    start = np.append(START, 0.0)
    run = solve_ivp(slope, (0, 8), start, "DOP853", rtol=1e-11, atol=1e-11)
    kinetic = np.asarray(model.energy(ordered(model, run.y[:7].T), **asdict(ROBOT))[0])
    assert np.ptp(run.y[7]) > 0.5 * kinetic.max()  # the work matters
    assert np.abs(kinetic - kinetic[0] - run.y[7]).max() < 1e-9 * kinetic.max()


# Whole motions


@pytest.mark.parametrize("robot", [ROBOT, OTHER, FREE])
@pytest.mark.parametrize("u", [(0.3, 0.1), (-0.2, 0.25), (0.2, 0.2)])
def test_constant_torques_follow_the_closed_form(
    model: Any, robot: DiffDrive, u: tuple[float, float]
) -> None:
    """Speed and turn fade exponentially, or grow linearly without drag."""
    held = np.array(u)
    end = simulate(model, START, lambda _: held, np.array([0.0, 6.0]), robot)[-1]
    expected = oracle.constant_torque_motion(START, held, 6.0, robot)
    np.testing.assert_allclose(end, expected, rtol=1e-9, atol=1e-9)  # quadrature and run 1e-11


def test_steps_follow_the_closed_form_to_fourth_order(model: Any) -> None:
    held = np.array([0.3, 0.1])
    expected = oracle.constant_torque_motion(START, held, 2.0, ROBOT)
    errors = []
    for steps in (20, 40, 80):
        x = ordered(model, START)
        for _ in range(steps):
            x = np.asarray(model.step(x, held, 2.0 / steps, **asdict(ROBOT)))
        errors.append(float(np.abs(restored(model, x) - expected)[:3].max()))
    assert errors[-1] > 1e-10  # the closed form, good to 1e-12, is far below
    assert 12 < errors[0] / errors[1] < 22
    assert 13 < errors[1] / errors[2] < 20


def test_an_undriven_robot_rolls_on_a_circle(model: Any) -> None:
    """Radius v / turn = (b / 2) (right + left) / (right - left), about a centre that stays."""
    left, right = START[5:]
    radius = FREE.b / 2 * (right + left) / (right - left)
    t = np.linspace(0.0, 20.0, 81)
    path = simulate(model, START, lambda _: np.zeros(2), t, FREE)
    turned = START[2] + t * FREE.r * (right - left) / FREE.b
    centre = START[:2] + radius * np.array([-np.sin(START[2]), np.cos(START[2])])
    expected = centre + radius * np.stack([np.sin(turned), -np.cos(turned)], axis=-1)
    np.testing.assert_allclose(path[:, :2], expected, rtol=0, atol=1e-9)  # [m]
    np.testing.assert_allclose(path[:, 2], turned, rtol=0, atol=1e-9)


def test_the_heading_is_read_off_the_wheels(model: Any) -> None:
    """r (phi_r - phi_l) - b psi stays: of the three constraints one can be integrated."""
    t = np.linspace(0.0, 8.0, 33)
    path = simulate(model, START, lambda s: np.array([np.sin(s), np.cos(2 * s)]) / 2, t, ROBOT)
    kept = ROBOT.r * (path[:, 4] - path[:, 3]) - ROBOT.b * path[:, 2]
    assert np.ptp(path[:, 2]) > 1.0  # [rad]: it turns
    assert np.ptp(kept) < 1e-10  # [m]


@pytest.mark.parametrize("robot", [ROBOT, OTHER, FREE])
def test_torques_of_the_flat_output_steer_the_axle_along_its_path(
    model: Any, robot: DiffDrive
) -> None:
    """A winding path with varying speed, open loop for 10 s; rtol 1e-12 of metres and radians."""
    t = sp.Symbol("t")
    path = [0.5 * t + 0.3 * sp.sin(0.7 * t), sp.sin(0.9 * t) + 0.05 * t**2]
    motion = oracle.flat_drive(path, t, robot)
    times = np.linspace(0.0, 10.0, 101)
    planned = np.array([motion(time) for time in times])
    start = np.concatenate([planned[0, :3], [0, 0], planned[0, 3:5]])
    driven = simulate(model, start, lambda s: motion(s)[5:], times, robot)
    np.testing.assert_allclose(driven[:, :2], planned[:, :2], rtol=0, atol=1e-6)  # [m]
    np.testing.assert_allclose(driven[:, [2, 5, 6]], planned[:, 2:5], rtol=0, atol=1e-6)
    assert np.ptp(planned[:, 2]) > 1.0  # [rad]: the path does wind
