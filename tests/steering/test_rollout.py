"""Following inputs against SciPy's DOP853, and the slopes of a step against its differences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kinolab
from kinolab.problem import PlanningTask
from kinolab.simulation.rollout import Rollout
from tests.scenes import apart, true_states

Scenes = Callable[..., PlanningTask]
Array = np.ndarray

MACHINES = ("car", "coin", "crane", "drive", "pendulum", "submarine", "two_cranes", "puck")


def drive(problem: PlanningTask, seed: int, steps: int) -> tuple[Array, Array]:
    """A state moving at up to 0.3 of its limits, and random inputs."""
    generator = np.random.default_rng(seed)
    x = problem.sample_goal(generator)
    x[problem.model.nq :] *= 0.3
    return x, generator.uniform(*problem.model.control_bounds.T, (steps, problem.model.nu))


# A Runge-Kutta step errs by some 1e-6; ten propagation steps are forty of them at most.
EXACT = 1e-5


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("seed", range(3))
def test_a_motion_of_ten_steps_is_followed_to_some_millionths_of_the_scales(
    machine: str, seed: int, scenes: Scenes
) -> None:
    problem = scenes(machine)
    x, u = drive(problem, seed, 10)
    states = Rollout(problem).follow(x, u)
    assert states is not None
    assert states[0] == pytest.approx(x, abs=0)
    assert apart(problem, states, true_states(problem, x, u)).max() < EXACT


def test_the_snakeboard_is_followed_to_some_millionths_of_the_scales() -> None:
    problem = kinolab.load("snakeboard_park")
    x, u = drive(problem, 1, 10)
    x[4] = 0.3  # steered: straight wheels leave nothing to push against
    states = Rollout(problem).follow(x, u)
    assert states is not None
    assert apart(problem, states, true_states(problem, x, u)).max() < EXACT


def test_the_problems_own_method_does_not_spoil_what_counts_as_exact(scenes: Scenes) -> None:
    """Euler's steps of a tenth of a second are off by percents."""
    problem = scenes("drive", 'integration.method="euler"')
    x, u = drive(problem, 5, 10)
    states = Rollout(problem).follow(x, u)
    assert states is not None
    assert apart(problem, states, true_states(problem, x, u)).max() < EXACT


def test_a_discrete_problem_is_followed_by_its_own_map(scenes: Scenes) -> None:
    problem = scenes("drive", 'integration.method="euler"', 'integration.truth="discrete"')
    x, u = drive(problem, 5, 10)
    states = Rollout(problem).follow(x, u)
    assert states is not None
    steps = states[:-1] + problem.step * problem.model.f(states[:-1], u)
    assert states[1:] == pytest.approx(steps, abs=1e-12)


def test_no_inputs_leave_the_machine_where_it_is(scenes: Scenes) -> None:
    problem = scenes("cart")
    states = Rollout(problem).follow(problem.start, np.zeros((0, 1)))
    assert states is not None
    assert (states == problem.start).all()
    assert states.shape == (1, 2)


def differences(problem: PlanningTask, x: Array, u: Array) -> tuple[Array, Array]:
    """Slopes of a step's end by its beginning and input, by central differences of DOP853."""
    moves = 1e-4 * np.concatenate([problem.scales, np.ptp(problem.model.control_bounds, axis=1)])
    columns = []
    for k, move in enumerate(moves):
        ends = []
        for sign in (1, -1):
            both = np.concatenate([x, u])
            both[k] += sign * move
            ends.append(true_states(problem, both[: len(x)], both[len(x) :][None])[-1])
        columns.append((ends[0] - ends[1]) / (2 * move))
    slopes = np.array(columns).T
    return slopes[:, : len(x)], slopes[:, len(x) :]


@pytest.mark.parametrize("machine", ["car", "coin", "crane", "drive", "pendulum", "two_cranes"])
def test_the_slopes_of_a_step_are_those_of_its_true_end(machine: str, scenes: Scenes) -> None:
    """Taken in the middle of the step they are of second order; half a step errs by a quarter."""
    errors = []
    for step in (0.1, 0.05):
        problem = scenes(machine, f"integration.step={step}")
        x, u = drive(problem, 2, 1)
        A, B = Rollout(problem).linearise(true_states(problem, x, u), u)
        true_A, true_B = differences(problem, x, u[0])
        half = np.ptp(problem.model.control_bounds, axis=1) / 2
        off = np.hstack([(A[0] - true_A) * problem.scales, (B[0] - true_B) * half])
        errors.append(float(np.abs(off / problem.scales[:, None]).max()))
    assert errors[0] < 0.02  # of a scale per scale
    assert errors[1] < errors[0] / 3


def test_the_slopes_of_a_linear_machine_are_exact(scenes: Scenes) -> None:
    """A cart of 1 kg: x + h v + h^2 u / 2 and v + h u."""
    cart, h = scenes("cart"), 0.1
    A, B = Rollout(cart).linearise(np.zeros((4, 2)), np.zeros((3, 1)))
    for k in range(3):
        assert A[k] == pytest.approx(np.array([[1, h], [0, 1]]), abs=1e-14)
        assert B[k] == pytest.approx(np.array([[h**2 / 2], [h]]), abs=1e-14)
