"""Ends that are hit exactly: against least norms, bang-bang control, and SciPy's DOP853."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import minimize

from kinolab.problem import PlanningTask
from kinolab.simulation.rollout import Rollout
from kinolab.steering.terminal_correction import TerminalCorrection
from tests.scenes import apart, true_states

Scenes = Callable[..., PlanningTask]
Array = np.ndarray


def closing(problem: PlanningTask) -> TerminalCorrection:
    return TerminalCorrection(problem, Rollout(problem))


def double_integrator(steps: int, h: float) -> Array:
    """Derivatives of the end (x, v) of a cart of 1 kg by the force in each step."""
    after = h * (steps - 0.5 - np.arange(steps))
    return np.array([h * after, np.full(steps, h)])


@pytest.mark.parametrize("end", [(1.0, 0.0), (-0.4, 0.3), (0.0, -0.5)])
def test_the_inputs_of_a_cart_are_those_of_least_norm(
    end: tuple[float, float], scenes: Scenes
) -> None:
    """The pseudo-inverse of a double integrator's response, in closed form."""
    cart = scenes("cart")
    found = closing(cart).correct(np.zeros(2), np.zeros((30, 1)), np.array(end))
    assert found is not None
    assert found.u[:, 0] == pytest.approx(
        np.linalg.pinv(double_integrator(30, 0.1)) @ end, abs=1e-7
    )
    assert found.x[-1] == pytest.approx(end, abs=1e-8)


def test_the_change_is_least_and_not_the_inputs(scenes: Scenes) -> None:
    cart, wave = scenes("cart"), 0.3 * np.sin(np.arange(30))[:, None]
    end = double_integrator(30, 0.1) @ wave[:, 0]
    found = closing(cart).correct(np.zeros(2), wave, np.add(end, [0.2, 0.0]))
    assert found is not None
    least = np.linalg.pinv(double_integrator(30, 0.1)) @ [0.2, 0.0]
    assert (found.u - wave)[:, 0] == pytest.approx(least, abs=1e-7)
    same = closing(cart).correct(np.zeros(2), wave, end)
    assert same is not None
    assert same.u == pytest.approx(wave, abs=1e-12)


def test_where_limits_are_reached_the_change_is_nearly_least(scenes: Scenes) -> None:
    """SciPy's SLSQP knows the least within the limits; fixing inputs at them comes close."""
    cart, end = scenes("cart"), np.array([1.9, 0.0])
    response = double_integrator(30, 0.1)
    found = closing(cart).correct(np.zeros(2), np.zeros((30, 1)), end)
    assert found is not None
    assert np.abs(found.u).max() <= 1.0
    assert (np.abs(found.u) == 1.0).any()
    best = minimize(
        lambda u: u @ u,
        np.zeros(30),
        jac=lambda u: 2 * u,
        bounds=[(-1, 1)] * 30,
        constraints={"type": "eq", "fun": lambda u: response @ u - end, "jac": lambda _: response},
        method="SLSQP",
    )
    assert best.success
    assert float((found.u**2).sum()) < 1.02 * best.fun


@pytest.mark.parametrize("distance", [0.5, 2.0, 4.5])
def test_a_cart_cannot_be_faster_than_bang_bang(distance: float, scenes: Scenes) -> None:
    """With 1 N for 1 kg a way of d takes at least 2 sqrt(d) from rest to rest."""
    cart, quickest = scenes("cart"), 2 * np.sqrt(distance)
    end = np.array([distance, 0.0])
    short, enough = (int(np.floor(factor * quickest / 0.1)) for factor in (0.99, 1.1))
    tool = closing(cart)
    assert tool.correct(np.zeros(2), np.zeros((short, 1)), end, most=50) is None
    found = tool.correct(np.zeros(2), np.zeros((enough + 1, 1)), end, most=50)
    assert found is not None
    assert np.abs(found.u).max() <= 1.0
    assert found.x[-1] == pytest.approx(end, abs=1e-8)


@pytest.mark.parametrize("machine", ["drive", "crane", "pendulum", "two_cranes", "submarine"])
@pytest.mark.parametrize("seed", range(3))
def test_an_end_that_inputs_lead_to_is_hit_from_inputs_nearby(
    machine: str, seed: int, scenes: Scenes
) -> None:
    """Within the limits, in truth, and with all that matters to the millionth."""
    problem, generator = scenes(machine), np.random.default_rng(seed)
    lower, upper = problem.model.control_bounds.T
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    u = middle + half * generator.uniform(-0.5, 0.5, (20, problem.model.nu))
    nearby = u + half * generator.uniform(-0.1, 0.1, u.shape)
    end = true_states(problem, problem.start, u)[-1]
    found = closing(problem).correct(problem.start, nearby, end)
    assert found is not None
    assert found.steps == 20
    assert ((lower <= found.u) & (found.u <= upper)).all()
    off = apart(problem, true_states(problem, problem.start, found.u)[-1], end)
    if machine == "drive":
        off = off[[0, 1, 2, 5, 6]]  # how far wheels have turned does not matter
    assert off.max() < 1e-5


def test_a_car_does_not_slip_sideways_to_its_end(scenes: Scenes) -> None:
    car = scenes("car")
    beside = np.add(car.start, [0, 1.0, 0, 0, 0, 0, 0])
    assert closing(car).correct(car.start, np.zeros((3, 2)), beside) is None


def test_angles_are_missed_the_short_way_round(scenes: Scenes) -> None:
    pendulum = scenes("pendulum")
    miss = closing(pendulum).residual(np.array([3.0, 0.0]), np.array([-3.0, 0.0]))
    assert miss[0] == pytest.approx(2 * np.pi - 6)
    full = closing(pendulum).residual(np.array([0.3, 0.0]), np.array([0.3 + 4 * np.pi, 0.0]))
    assert full[0] == pytest.approx(0.0, abs=1e-12)


def test_a_quaternion_and_its_opposite_are_the_same_attitude(scenes: Scenes) -> None:
    submarine = scenes("submarine")
    x = submarine.start.copy()
    x[3:7] = np.array([0.1, -0.2, 0.3, 0.9]) / np.linalg.norm([0.1, -0.2, 0.3, 0.9])
    other = x.copy()
    other[3:7] *= -1
    assert np.abs(closing(submarine).residual(x, other)).max() < 1e-15


def test_no_inputs_end_where_they_begin(scenes: Scenes) -> None:
    """There is nothing to correct."""
    cart = scenes("cart")
    there = closing(cart).correct(np.zeros(2), np.zeros((0, 1)), np.zeros(2))
    assert there is not None
    assert there.steps == 0
    assert closing(cart).correct(np.zeros(2), np.zeros((0, 1)), np.array([1.0, 0.0])) is None


def test_inputs_beyond_their_limits_are_brought_within(scenes: Scenes) -> None:
    cart = scenes("cart")
    found = closing(cart).correct(np.zeros(2), np.full((40, 1), 7.0), np.array([1.0, 0.0]), most=50)
    assert found is not None
    assert np.abs(found.u).max() <= 1.0
