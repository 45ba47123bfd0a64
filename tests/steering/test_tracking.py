"""Feedback against Riccati's equation iterated by hand, and least squares over a whole horizon."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from kinolab.problem import PlanningTask
from kinolab.simulation.rollout import Rollout
from kinolab.steering import Maneuver, TrackingLaw, cyclic_coordinates, nearest_equilibrium
from kinolab.steering.tracking import CONTROL_WEIGHT, TERMINAL_WEIGHT
from tests.scenes import apart, true_states

Scenes = Callable[..., PlanningTask]
Array = np.ndarray


def tracker(problem: PlanningTask) -> TrackingLaw:
    return TrackingLaw(problem, Rollout(problem))


def weights(problem: PlanningTask) -> tuple[Array, Array]:
    """Of states by their scales and of inputs by half their range."""
    half = np.ptp(problem.model.control_bounds, axis=1) / 2
    return np.diag(1 / problem.scales**2), CONTROL_WEIGHT * np.diag(1 / half**2)


def gain_by_iteration(A: Array, B: Array, Q: Array, R: Array) -> Array:
    """Value iteration from nothing until it stands still."""
    P = np.zeros_like(Q)
    for _ in range(100_000):
        K = np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
        after = Q + A.T @ P @ (A - B @ K)
        if np.abs(after - P).max() < 1e-13 * np.abs(after).max():
            break
        P = after
    return K


def test_a_cart_is_held_by_the_gain_that_value_iteration_finds(scenes: Scenes) -> None:
    cart, h = scenes("cart"), 0.1
    A, B = np.array([[1, h], [0, 1]]), np.array([[h**2 / 2], [h]])
    best = gain_by_iteration(A, B, *weights(cart))
    assert tracker(cart).hold(np.zeros(2), np.zeros(1)) == pytest.approx(best, rel=1e-7)


@pytest.mark.parametrize(("angle", "sign"), [(np.pi, 1), (0.0, -1)])
def test_a_pendulum_is_held_upright_and_hanging_by_the_best_gain(
    angle: float, sign: int, scenes: Scenes
) -> None:
    """About upright theta grows with cosh(w t), about hanging it swings; w^2 = g / l."""
    pendulum, h, w = scenes("pendulum"), 0.05, np.sqrt(9.81)
    even, odd = (np.cosh, np.sinh) if sign > 0 else (np.cos, np.sin)
    c, s = float(even(w * h)), float(odd(w * h))
    A = np.array([[c, s / w], [sign * w * s, c]])
    B = np.array([[sign * (c - 1) / w**2], [s / w]])
    K = tracker(pendulum).hold(np.array([angle, 0.0]), np.zeros(1))
    assert K is not None
    best = gain_by_iteration(A, B, *weights(pendulum))
    assert np.abs(K - best).max() < 1e-6 * np.abs(best).max()
    assert np.abs(np.linalg.eigvals(A - B @ K)).max() < 1.0


@pytest.mark.parametrize("machine", ["crane", "two_cranes", "wagons", "lift"])
def test_what_is_held_returns_in_truth(machine: str, scenes: Scenes) -> None:
    """From a thousandth of the scales off, in closed loop through DOP853, by half and more."""
    problem = scenes(machine)
    found = nearest_equilibrium(problem, problem.start)
    assert found is not None
    x1, u1 = found
    K = tracker(problem).hold(x1, u1)
    assert K is not None
    x = x1 + 1e-3 * problem.scales * np.random.default_rng(0).uniform(-1, 1, len(x1))
    for _ in range(150):
        x = true_states(problem, x, (u1 - K @ (x - x1))[None])[-1]
    assert np.linalg.norm((x - x1) / problem.scales) < 5e-4


@pytest.mark.parametrize("machine", ["car", "drive", "coin", "puck", "submarine"])
def test_what_does_not_slip_sideways_is_held_by_no_linear_feedback(
    machine: str, scenes: Scenes
) -> None:
    """Brockett's condition; a puck without thrust does not move aside either."""
    problem = scenes(machine)
    found = nearest_equilibrium(problem, problem.start)
    assert found is not None
    assert tracker(problem).hold(*found) is None


def best_first_input(A: Array, B: Array, Q: Array, R: Array, x: Array, steps: int) -> Array:
    """The first input of the best ones over a horizon, by least squares over all of them."""
    rows, right, reach, free = [], [], np.zeros((len(x), steps * B.shape[1])), x
    root_Q, root_R = np.linalg.cholesky(Q).T, np.linalg.cholesky(R).T
    for k in range(steps):
        block = np.zeros((B.shape[1], steps * B.shape[1]))
        block[:, k * B.shape[1] : (k + 1) * B.shape[1]] = np.eye(B.shape[1])
        rows.append(root_R @ block)
        right.append(np.zeros(B.shape[1]))
        reach, free = A @ reach + B @ block, A @ free
        share = np.sqrt(TERMINAL_WEIGHT) if k == steps - 1 else 1.0
        rows.append(share * root_Q @ reach)
        right.append(-share * root_Q @ free)
    return np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0][: B.shape[1]]


@pytest.mark.parametrize("steps", [1, 2, 15])
def test_gains_along_a_motion_give_the_best_inputs_for_the_rest_of_it(
    steps: int, scenes: Scenes
) -> None:
    wagons = scenes("wagons")
    still = Maneuver(np.zeros((steps + 1, 4)), np.zeros((steps, 1)))
    A, B = Rollout(wagons).linearise(still.x, still.u)
    gains = tracker(wagons).gains(still)
    assert gains.shape == (steps, 1, 4)
    x = np.array([0.3, -0.2, 0.5, 0.1])
    for k in range(steps):
        best = best_first_input(A[0], B[0], *weights(wagons), x, steps - k)
        assert -gains[k] @ x == pytest.approx(best, abs=1e-8)
        x = A[0] @ x + B[0] @ best


def test_feedback_for_a_long_horizon_is_that_of_an_endless_one(scenes: Scenes) -> None:
    wagons = scenes("wagons")
    still = Maneuver(np.zeros((401, 4)), np.zeros((400, 1)))
    tool = tracker(wagons)
    assert tool.gains(still)[0] == pytest.approx(tool.hold(still.x[0], still.u[0]), rel=1e-6)


@pytest.mark.parametrize("machine", ["crane", "two_cranes", "drive"])
def test_feedback_comes_nearer_to_a_motion_than_its_inputs_alone(
    machine: str, scenes: Scenes
) -> None:
    problem, generator = scenes(machine), np.random.default_rng(7)
    lower, upper = problem.model.control_bounds.T
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    u = middle + half * 0.3 * np.sin(np.arange(60) / 6)[:, None]
    states = Rollout(problem).follow(problem.start, u)
    assert states is not None
    motion, tool = Maneuver(states, u), tracker(problem)
    same = tool.track(problem.start, motion)
    assert same is not None
    assert same.x == pytest.approx(motion.x, abs=1e-9)
    beside = problem.start + 0.05 * problem.scales * generator.uniform(-1, 1, len(states[0]))
    back, alone = tool.track(beside, motion), Rollout(problem).follow(beside, u)
    assert back is not None
    assert alone is not None
    assert ((lower <= back.u) & (back.u <= upper)).all()
    left = [apart(problem, x, motion.x[-1]) for x in (back.x[-1], alone[-1])]
    matters = ~cyclic_coordinates(problem)
    assert np.linalg.norm(left[0][matters]) < 0.75 * np.linalg.norm(left[1][matters])
    assert apart(problem, back.x, true_states(problem, back.x[0], back.u)).max() < 1e-4
