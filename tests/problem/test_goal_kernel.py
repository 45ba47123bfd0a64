"""The errors of a goal: compiled as in NumPy, smooth as sharp, with the exact slope of poses."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.problem import PlanningTask
from kinolab.problem.goal import angle_between
from kinolab.problem.goal_kernel import axis_angle, body_violation, goal_arrays, state_violation
from tests.support import problem_of

NAMES = ("crane_factory", "rolling_disk_maze", "satellite_pointing", "submarine_corridor")

ARM = """
schema = 1
title = "Reach"
[system]
name = "pendulum"
[[goal.point]]
body = "bob"
position = [0.0, 1.0, 0.3]
tolerance = 0.1
[[goal.direction]]
body = "bob"
axis = "x"
target = [0, 5, 0]
tolerance = 0.2
"""


def violation(problem: PlanningTask, x: np.ndarray) -> float:
    """Return how far outside the goal compiled code takes a state to be."""
    goal = goal_arrays(problem.goal)
    far = state_violation(goal, x, math.inf)
    return float(body_violation(goal, problem.frames(x), far))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("norm", ["max", "sum", "euclidean"])
def test_compiled_code_measures_as_the_goal_itself(name: str, norm: str) -> None:
    problem = kinolab.load(name)
    problem = replace(problem, goal=replace(problem.goal, norm=norm))
    random = np.random.default_rng(0)
    for spread in random.uniform(0.0, 8.0, 50):
        x = problem.sample_goal(random, spread)
        assert violation(problem, x) == pytest.approx(problem.goal_excess(x), rel=1e-12, abs=1e-12)


def test_points_and_axes_are_measured_in_compiled_code_too(tmp_path: Path) -> None:
    """At theta = pi / 2 the axis is on its target and the point is 0.3 m away: 3 tolerances."""
    problem = problem_of(tmp_path, ARM)
    assert violation(problem, np.array([np.pi / 2, 0.0])) == pytest.approx(3.0, abs=1e-12)
    for theta in np.linspace(-3.0, 3.0, 13):
        turned = abs(math.remainder(theta - np.pi / 2, 2 * np.pi))
        away = math.hypot(2 * math.sin(turned / 2), 0.3)
        wanted = max(turned / 0.2, away / 0.1)
        assert violation(problem, np.array([theta, 0.0])) == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 0.3, np.pi / 2, np.pi - 1e-8, np.pi - 1e-12])
def test_angles_are_sharp_where_their_cosine_is_not(angle: float) -> None:
    """Near 0 and near pi the cosine does not change within rounding."""
    pose = np.hstack([np.eye(3), np.zeros((3, 1))]).ravel()
    axis, target = np.array([1.0, 0.0, 0.0]), np.array([math.cos(angle), math.sin(angle), 0.0])
    assert axis_angle(pose, axis, target) == pytest.approx(angle, abs=1e-15)
    assert angle_between(axis, target) == pytest.approx(angle, abs=1e-15)


@pytest.mark.parametrize("name", NAMES)
def test_the_residual_vanishes_to_first_order_as_the_errors_do(name: str) -> None:
    """Near the goal's middle its vectors are as long as errors in tolerances; nearer, more so."""
    problem, random = kinolab.load(name), np.random.default_rng(1)
    count = len(problem.goal.indices)
    for spread in (1e-2, 1e-4):
        x = problem.sample_goal(random, spread)
        errors = problem.goal_errors(x) / problem.goal.error_tolerances
        residual = problem.goal_residual(x)
        lengths = np.linalg.norm(residual[count:].reshape(-1, 3), axis=1)
        assert np.abs(residual[:count]) == pytest.approx(np.abs(errors[:count]), abs=1e-14)
        assert lengths == pytest.approx(errors[count:], rel=1e-3, abs=1e-12)


def test_targets_of_bodies_have_the_slope_that_poses_have(tmp_path: Path) -> None:
    """What is linear in poses is taken of their derivative: against central differences."""
    h = 1e-6
    for problem in (problem_of(tmp_path, ARM), kinolab.load("satellite_pointing")):
        x = problem.sample(np.random.default_rng(2))
        columns = np.moveaxis(problem.model.frames_jacobian(x), -1, 0)
        for target in (*problem.goal.of_bodies, *problem.keep_outs):
            for j, slope in enumerate(target.in_world(columns)):
                step = h * np.eye(len(x))[j]
                ends = (target.in_world(problem.frames(x + sign * step)) for sign in (1, -1))
                assert slope == pytest.approx(np.subtract(*ends) / (2 * h), abs=1e-8)
